"""N objects of the model as one: numbers that differ become arrays, one element for each trial."""

import types
from collections import deque
from collections.abc import Sequence
from random import Random
from typing import Any

import numpy as np
from pydantic import BaseModel

from heatwright.sim.arrays.builtin import Each
from heatwright.spec import LoopFacts

_NUMBERS = (bool, int, float, np.generic)
ON_ARRAYS = " on arrays"
"""Suffix of the names of translated modules."""
_KINDS = {bool: np.bool_, int: np.int64, float: np.float64}


class UnlikeError(Exception):
    """The lanes differ in their structure; only differences of numbers are allowed."""


def stacked(objects: Sequence[Any]) -> Any:
    """Return one object for all lanes. Raises UnlikeError: they differ by more than numbers."""
    return _Stack().joined(tuple(objects))


class Specs:
    """Parts of specs that differ only in numbers, read as one."""

    def __init__(self, models: Sequence[BaseModel | LoopFacts]) -> None:
        """Store the parts, in the order of the lanes."""
        self.__dict__["_models"] = tuple(models)

    @property  # type: ignore[misc]
    def __class__(self) -> type:  # isinstance uses this
        return type(self.__dict__["_models"][0])

    def __getattr__(self, name: str) -> Any:
        """Return an attribute, combined over all lanes."""
        found = stacked([getattr(each, name) for each in self.__dict__["_models"]])
        self.__dict__[name] = found
        return found


class _Stack:
    def __init__(self) -> None:
        self._known: dict[tuple[int, ...], Any] = {}

    def joined(self, values: tuple[Any, ...]) -> Any:
        first = values[0]
        if all(each is first for each in values):
            return first
        kind = type(first)
        if any(type(each) is not kind for each in values):
            raise UnlikeError(f"{', '.join(sorted({type(each).__name__ for each in values}))}")
        if isinstance(first, _NUMBERS):
            return _numbers(values)
        key = tuple(map(id, values))
        if key not in self._known:
            self._known[key] = self._new(values, key)
        return self._known[key]

    def _new(self, values: tuple[Any, ...], key: tuple[int, ...]) -> Any:
        first = values[0]
        if isinstance(first, Random):
            return Each(values)
        if isinstance(first, types.MethodType):
            holder = self.joined(tuple(each.__self__ for each in values))
            return types.MethodType(first.__func__, holder)
        if isinstance(first, types.FunctionType):
            return self._function(values)
        if isinstance(first, tuple | list | deque | dict):
            return self._collection(values, key)
        if type(first).__module__.endswith(ON_ARRAYS):
            return self._object(values, key)
        return _others(values)

    def _object(self, values: tuple[Any, ...], key: tuple[int, ...]) -> Any:
        """Join objects of the model's own classes."""
        kind = type(values[0])
        found = self._known[key] = object.__new__(kind)
        found.__dict__.update(self._table([vars(each) for each in values]))
        return found

    def _collection(self, values: tuple[Any, ...], key: tuple[int, ...]) -> Any:
        first = values[0]
        if isinstance(first, tuple):
            parts = self._parts(values)
            return first._make(parts) if hasattr(first, "_make") else tuple(parts)
        found = self._known[key] = type(first)()
        if isinstance(first, dict):
            found.update(self._table(values))
        else:
            found.extend(self._parts(values))
        return found

    def _table(self, values: Sequence[dict[Any, Any]]) -> dict[Any, Any]:
        if any(each.keys() != values[0].keys() for each in values):
            raise UnlikeError(f"the keys {list(values[0])} and others")
        return {name: self.joined(tuple(each[name] for each in values)) for name in values[0]}

    def _parts(self, values: tuple[Any, ...]) -> list[Any]:
        if len({len(each) for each in values}) > 1:
            raise UnlikeError(f"lengths of {values[0]!r} and others")
        return [self.joined(each) for each in zip(*values, strict=True)]

    def _function(self, values: tuple[Any, ...]) -> Any:
        first = values[0]
        if any(each.__code__ is not first.__code__ for each in values):
            raise UnlikeError(first.__name__)
        if not first.__closure__:
            return first
        cells = self._parts(
            tuple(tuple(cell.cell_contents for cell in each.__closure__) for each in values)
        )
        return types.FunctionType(
            first.__code__, first.__globals__, first.__name__, first.__defaults__,
            tuple(map(types.CellType, cells)),
        )  # fmt: skip


def _others(values: tuple[Any, ...]) -> Any:
    """Combine values that are no objects of the model: equal ones, or parts of specs."""
    if all(each == values[0] for each in values):
        return values[0]
    if isinstance(values[0], BaseModel | LoopFacts):
        return Specs(values)
    raise UnlikeError(f"{values[0]!r} and others")


def _numbers(values: tuple[Any, ...]) -> Any:
    first = values[0]
    if all(each == first for each in values) and not (first == 0 and _signs_differ(values)):
        return first
    return np.array(values, _KINDS.get(type(first), type(first)))


def _signs_differ(values: tuple[Any, ...]) -> bool:
    return len({bool(np.signbit(each)) for each in values}) > 1
