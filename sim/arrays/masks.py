"""Functions that the translated model calls: they track the active lanes and merge their values.

A lane is one of the trials that are simulated side by side. A value is either one object for all
lanes, or an array with an element for each lane. `active` masks the lanes that run now; None: all.
"""

import operator
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Value = Any

_NUMBERS = (np.ndarray, np.generic, int, float, str)
"""Includes str: an array may have one name for each lane."""


class AllLanesError(Exception):
    """Something that all lanes share would be changed for some lanes only."""


class _Unset:
    """Placeholder for a value that no lane has yet."""


UNSET = _Unset()


class _State:
    """The mask of the active lanes; None: all."""

    active: Mask | None = None


NOW = _State()


def has_array(values: Sequence[Value]) -> bool:
    """Return whether any of the values is an array."""
    return np.ndarray in map(type, values) or Maybe in map(type, values)


def truth(test: Value) -> Mask:
    """Return an array as truth values."""
    found: Mask = test if test.dtype == np.bool_ else test != ("" if test.dtype.kind == "U" else 0)
    return found


def merged(mask: Mask, new: Value, old: Value) -> Value:
    """Return the new value for the lanes of a mask, the old one for the others.

    Raises AllLanesError: the values differ in more than their numbers.
    """
    if new is old or old is UNSET:
        return new
    if isinstance(new, _NUMBERS) and isinstance(old, _NUMBERS):
        found = np.where(mask, new, old)
        if isinstance(new, Maybe) or isinstance(old, Maybe):
            return _lacking(np.where(mask, is_none(new), is_none(old)), found)
        return found
    if new is None or old is None:
        return _lacking(mask, old) if new is None else _lacking(~mask, new)
    return _merged_parts(mask, new, old)


def _merged_parts(mask: Mask, new: Value, old: Value) -> Value:
    if isinstance(new, tuple | list) and _alike(new, old):
        each = [merged(mask, *pair) for pair in zip(new, old, strict=True)]
        return each if isinstance(new, list) else _tuple_as(new, each)
    if isinstance(new, dict) and isinstance(old, dict) and new.keys() == old.keys():
        return {key: merged(mask, value, old[key]) for key, value in new.items()}
    if type(new) is type(old) and new == old:
        return new
    raise AllLanesError(f"{new!r} for some lanes, {old!r} for others")


def _tuple_as(kind: Value, parts: list[Value]) -> Value:
    return type(kind)._make(parts) if hasattr(kind, "_make") else tuple(parts)


def _alike(new: Value, old: Value) -> bool:
    """Return whether two values have equal lengths, and types of equal names (see translate)."""
    return type(new).__name__ == type(old).__name__ and len(new) == len(old)


class Maybe(np.ndarray):
    """Numbers that some lanes have, and None for the others."""

    missing: Mask | bool = False


def _lacking(mask: Value, value: Value) -> Value:
    """Return numbers that are None for the lanes of a mask."""
    if isinstance(value, tuple):
        return _tuple_as(value, [_lacking(mask, part) for part in value])
    if not isinstance(value, _NUMBERS):
        raise AllLanesError(f"{value!r} for some lanes, None for others")
    found = np.broadcast_to(value, mask.shape).view(Maybe)
    found.missing = mask | is_none(value)
    return found


def is_none(value: Value) -> Value:
    """Return whether a value is None: a bool, or an array with a bool for each lane."""
    if isinstance(value, tuple) and value:
        value = value[0]
    return value.missing if isinstance(value, Maybe) else value is None


class Frame:
    """A function call from which some lanes may return before others."""

    __slots__ = ("value", "whole")

    def __init__(self) -> None:
        """Keep which lanes are active now: all that may run this."""
        self.whole = NOW.active
        self.value: Value = UNSET

    def is_whole(self) -> bool:
        """Return whether all lanes that began the call are active."""
        return NOW.active is self.whole

    def set(self, old: Value, new: Value) -> Value:
        """Return the new value of a local variable: changed for the active lanes."""
        return new if NOW.active is self.whole else merged(_mask(), new, old)

    def leave(self, value: Value) -> None:
        """Let the active lanes return a value."""
        mask = _mask()
        self.value = merged(mask, value, self.value)
        NOW.active = np.zeros_like(mask)

    def goes_on(self) -> bool:
        """Return whether any lane has not returned yet."""
        return NOW.active is self.whole or bool(_mask().any())

    def end(self, value: Value = None) -> Value:
        """Return the values of all lanes; the lanes still active return this value."""
        if NOW.active is self.whole:
            return value
        if value is not None or self.value is UNSET:
            value = merged(_mask(), value, self.value)
        else:
            value = self.value
        NOW.active = self.whole
        return value


def _mask() -> Mask:
    if NOW.active is None:
        raise AllLanesError("All lanes are active where only some may be")
    return NOW.active


def split(test: Value) -> Iterable[bool]:
    """Yield the branches of an `if` that any lanes take, with only those lanes active."""
    if isinstance(test, np.ndarray):
        return _ways(test)
    return _YES if test else _NO


_YES, _NO = (True,), (False,)


def _ways(test: Value) -> Iterator[bool]:
    whole, true = NOW.active, truth(test)
    yes = true if whole is None else true & whole
    if not yes.any():
        yield False
        return
    no = ~true if whole is None else whole & ~true
    if not no.any():
        yield True
        return
    NOW.active = yes
    yield True
    left = NOW.active
    NOW.active = no
    yield False
    unchanged = left is yes and NOW.active is no
    NOW.active = whole if unchanged else left | NOW.active


class While:
    """A loop that some lanes leave before others."""

    __slots__ = ("_left", "_whole")

    def __init__(self) -> None:
        """Keep which lanes are active now: all that may run this."""
        self._whole = NOW.active
        self._left: Mask | None = None

    def again(self, test: Value) -> bool:
        """Return whether any lane goes on, and make those lanes the active ones."""
        if not isinstance(test, np.ndarray):
            return bool(test)
        true, before = truth(test), NOW.active
        stay = true if before is None else true & before
        out = ~true if before is None else before & ~true
        if out.any():
            self._left = out if self._left is None else self._left | out
            NOW.active = stay
        return bool(stay.any())

    def end(self) -> None:
        """Reactivate the lanes that left the loop, except those that returned from the function."""
        if self._left is None:
            return
        left = self._left if NOW.active is None else self._left | NOW.active
        NOW.active = self._whole if self._whole is None and left.all() else left
        if self._whole is not None and np.array_equal(left, self._whole):
            NOW.active = self._whole


def together(before: Mask | None) -> None:
    """Refuse a `break` or `continue` of some lanes only."""
    if NOW.active is not before:
        raise AllLanesError("Only some lanes would break off or continue a loop")


def common(value: Value) -> Value:
    """Return a collection that will be changed in place; refuse unless all lanes are active."""
    if NOW.active is not None and isinstance(value, list | dict | set | deque):
        raise AllLanesError("A collection would change for some lanes only")
    return value


def raises() -> bool:
    """Return whether to raise an exception; refuse if only some lanes raise it: all would end."""
    if NOW.active is not None and NOW.active.any():
        raise AllLanesError("Only some lanes would raise an exception")
    return NOW.active is None


@contextmanager
def only(lanes: Mask | None) -> Iterator[None]:
    """Make only these lanes active; None: all."""
    before, NOW.active = NOW.active, lanes
    try:
        yield
    finally:
        NOW.active = before


@contextmanager
def afresh() -> Iterator[None]:
    """Make all lanes active, without numpy's warnings: unneeded results may be arbitrary."""
    with only(None), np.errstate(all="ignore"):
        yield


def put(target: Value, name: str, value: Value) -> None:
    """Set an attribute for the active lanes."""
    if NOW.active is not None:
        value = merged(NOW.active, value, getattr(target, name, UNSET))
    setattr(target, name, value)


def put_item(target: Value, key: Value, value: Value) -> None:
    """Set an item for the active lanes."""
    mask = NOW.active
    if isinstance(key, np.ndarray):
        for place in range(len(target)):
            here = key == place if mask is None else mask & (key == place)
            target[place] = merged(here, value, target[place])
        return
    if mask is not None:
        before = target.get(key, UNSET) if isinstance(target, dict) else target[key]
        value = merged(mask, value, before)
    target[key] = value


def item(source: Value, key: Value) -> Value:
    """Return an item; each lane gets its own item of a sequence or table."""
    if not isinstance(key, np.ndarray):
        return source[key]
    if isinstance(source, list) and not has_array(source):
        return np.array(source)[key if NOW.active is None else np.where(NOW.active, key, 0)]
    pairs = source.items() if isinstance(source, Mapping) else enumerate(source)
    found: Value = UNSET
    known = np.zeros(key.shape, bool)
    for place, value in pairs:
        here = key == place
        found = merged(here, value, found)
        known |= here
    if not (known if NOW.active is None else known | ~NOW.active).all():
        raise IndexError(key)
    return found


def and_(left: Value, right: Callable[[], Value]) -> Value:
    """Return `left and right`."""
    if not isinstance(left, np.ndarray):
        return left and right()
    return _joined(left, right, truth(left))


def or_(left: Value, right: Callable[[], Value]) -> Value:
    """Return `left or right`."""
    if not isinstance(left, np.ndarray):
        return left or right()
    return _joined(left, right, ~truth(left))


def _joined(left: Value, right: Callable[[], Value], asked: Mask) -> Value:
    """Return the right operand for the lanes that need it, otherwise the left one."""
    whole = NOW.active
    asked = asked if whole is None else asked & whole
    if not asked.any():
        return left
    NOW.active = asked
    found = right()
    NOW.active = whole
    return merged(asked, found, left)


def both(left: Value, right: Callable[[], Value]) -> Value:
    """Return `left and right` where right calls nothing, so all lanes may evaluate it."""
    if not isinstance(left, np.ndarray):
        return left and right()
    found = right()
    if left.dtype == np.bool_ and isinstance(found, bool | np.bool_ | np.ndarray):
        return left & (truth(found) if isinstance(found, np.ndarray) else found)
    return merged(truth(left), found, left)


def either(left: Value, right: Callable[[], Value]) -> Value:
    """Return `left or right` where right calls nothing."""
    if not isinstance(left, np.ndarray):
        return left or right()
    found = right()
    if left.dtype == np.bool_ and isinstance(found, bool | np.bool_ | np.ndarray):
        return left | (truth(found) if isinstance(found, np.ndarray) else found)
    return merged(~truth(left), found, left)


def not_(value: Value) -> Value:
    """Return `not value`."""
    return ~truth(value) if isinstance(value, np.ndarray) else not value


def choose(test: Value, yes: Callable[[], Value], no: Callable[[], Value]) -> Value:
    """Return `yes if test else no`."""
    if not isinstance(test, np.ndarray):
        return yes() if test else no()
    found: Value = UNSET
    for way in split(test):
        value = yes() if way else no()
        found = value if found is UNSET else merged(truth(test), found, value)
    return found


def chain(first: Value, *rest: Value) -> Value:
    """Return a chained comparison: a value, then operators and values in turn."""
    result: Value = True
    for compare, value in zip(rest[::2], rest[1::2], strict=True):
        result = both(result, partial(compare, first, value))
        first = value
    return result


def any_of(values: Iterable[Value]) -> Value:
    """Return `any(values)`."""
    result: Value = False
    for value in values:
        result = either(result, partial(_same, value))
    return result


def all_of(values: Iterable[Value]) -> Value:
    """Return `all(values)`."""
    result: Value = True
    for value in values:
        result = both(result, partial(_same, value))
    return result


def _same(value: Value) -> Value:
    return value


def among(value: Value, values: tuple[Value, ...]) -> Value:
    """Return `value in values`."""
    if not has_array((value, *values)):
        return value in values
    return any_of(value == each for each in values)


COMPARISONS = {
    "Lt": operator.lt, "LtE": operator.le, "Gt": operator.gt, "GtE": operator.ge,
    "Eq": operator.eq, "NotEq": operator.ne,
}  # fmt: skip
