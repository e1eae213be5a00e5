"""Built-in functions, and those of `math` and `bisect`, that also take arrays."""

import math
import operator
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from heatwright.sim.arrays.masks import NOW, Value, all_of, any_of, has_array


def _extreme(
    plain: Callable[..., Value],
    better: Callable[[Value, Value], Value],
    *values: Value,
    **words: Value,
) -> Value:
    """Return `plain(*values, **words)`: the value that is better than all others."""
    listed = list(values[0]) if len(values) == 1 else list(values)
    if words or not has_array(listed):
        return plain(listed, **words)
    best = listed[0]
    for value in listed[1:]:
        best = np.where(better(value, best), value, best)
    return best


def _number(kind: type, to: type) -> type:
    """Return a number type whose calls also convert arrays."""

    def new(cls: type, value: Value = 0, *more: Value) -> Value:
        del cls
        return value.astype(to) if isinstance(value, np.ndarray) else kind(value, *more)

    return type(kind.__name__, (int if kind is bool else kind,), {"__new__": new})


def _round(value: Value, *digits: int) -> Value:
    if isinstance(value, np.ndarray) and not digits:
        return np.rint(value).astype(np.int64)
    return round(value, *digits)


BUILTINS: dict[str, Value] = {
    "min": partial(_extreme, min, operator.lt), "max": partial(_extreme, max, operator.gt),
    "any": any_of, "all": all_of, "round": _round, "int": _number(int, np.int64),
    "float": _number(float, np.float64), "bool": _number(bool, np.bool_),
}  # fmt: skip


class Math:
    """The module `math`, with rounding functions that also take arrays."""

    def __getattr__(self, name: str) -> Value:
        """Return any other attribute of `math`."""
        return getattr(math, name)

    @staticmethod
    def floor(value: Value) -> Value:
        """Round a number, or each number of an array, down to an integer."""
        if isinstance(value, np.ndarray):
            return np.floor(value).astype(np.int64)
        return math.floor(value)


class Bisect:
    """The module `bisect`, with a function that also takes arrays."""

    @staticmethod
    def bisect_right(values: Sequence[Value], value: Value) -> Value:
        """Count how many of the sorted values are not above a value."""
        if not isinstance(value, np.ndarray) and not has_array(values):
            return bisect_right(values, value)
        if not has_array(values):
            return np.searchsorted(values, value, side="right")
        return sum((each <= value).astype(np.int64) for each in values)


class Each:
    """One separate object for each lane, whose methods return numbers."""

    def __init__(self, objects: Sequence[Value]) -> None:
        """Store the objects, in the order of the lanes."""
        self._objects = tuple(objects)

    def __getattr__(self, name: str) -> Callable[..., Value]:
        """Return a function that calls this method for each active lane."""

        def call(*arguments: Value) -> Value:
            found = np.zeros(len(self._objects))
            lanes = range(len(found)) if NOW.active is None else np.flatnonzero(NOW.active)
            for lane in lanes:
                own = (a[lane] if isinstance(a, np.ndarray) else a for a in arguments)
                found[lane] = getattr(self._objects[lane], name)(*own)
            return found

        return call
