"""What is left of a spec without its broken parts, so that the rest can still be checked."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from heatwright.spec.controller import FORMAT, Controller
from heatwright.spec.problems import Path
from heatwright.spec.shape import locate

_STAND_INS: dict[Path, object] = {("heatwright",): FORMAT, ("controller", "name"): "unnamed"}
"""Required, and of no account for the checks."""

_MOST_ROUNDS = 12
"""Each round takes broken entries out, or what cannot be without them: no deeper than nesting."""


def salvage(data: Any, broken: Iterable[Path]) -> Controller | None:
    """Make a controller of the entries that are whole; None if too little is left."""
    data = _copy(data)
    out = set(broken)
    for _ in range(_MOST_ROUNDS):
        for path in out:
            _take_out(data, path)
        try:
            return Controller.model_validate(data)
        except ValidationError as error:
            places = {locate(Controller, entry["loc"]).path for entry in error.errors()}
        out = {path if _holds(data, path) else path[:-1] for path in places}
        if () in out:
            return None
    return None


def _copy(data: Any) -> Any:
    return {key: _copy(value) for key, value in data.items()} if isinstance(data, dict) else data


def _mapping_at(data: Any, path: Path) -> tuple[Any, Path]:
    """Follow a path through mappings, as far as there are some; give the last and its path."""
    for depth, key in enumerate(path[:-1]):
        inner = data.get(key)
        if not isinstance(inner, dict):
            return data, path[: depth + 1]
        data = inner
    return data, path


def _holds(data: Any, path: Path) -> bool:
    mapping, path = _mapping_at(data, path)
    return isinstance(mapping, dict) and path[-1] in mapping


def _take_out(data: Any, path: Path) -> None:
    """Delete an entry, or the list it is in: what follows it there would change its place."""
    if not isinstance(data, dict) or not path:
        return
    mapping, path = _mapping_at(data, path)
    if path in _STAND_INS:
        mapping[path[-1]] = _STAND_INS[path]
    else:
        mapping.pop(path[-1], None)
