"""Removes broken parts from a spec, so that the rest can still be checked."""

from typing import Any

from pydantic import ValidationError

from heatwright.spec.controller import FORMAT, Controller
from heatwright.spec.loading.shape import Place, keys, locate
from heatwright.spec.problems import Path
from heatwright.spec.quantity import Quantity

_STAND_INS: dict[Path, object] = {("heatwright",): FORMAT, ("controller", "name"): "unnamed"}
"""Substitutes for required keys whose values the checks do not use."""

_MOST_ROUNDS = 12
"""Maximum number of rounds: each replaces or removes broken entries, or entries that need them."""


def without_broken_parts(data: Any) -> Controller | None:
    """Make a controller of the valid entries; None if too few are left.

    A required quantity is replaced by an example of its kind, anything else is left out. Later
    findings about such entries are not reliable; all others are.
    """
    data = _copy(data)
    for _ in range(_MOST_ROUNDS):
        try:
            return Controller.model_validate(data)
        except ValidationError as error:
            places = [locate(Controller, entry["loc"]) for entry in error.errors()]
        if any(len(place.path) == 0 for place in places):
            return None
        for place in places:
            _mend(data, place)
    return None


def _copy(data: Any) -> Any:
    return {key: _copy(value) for key, value in data.items()} if isinstance(data, dict) else data


def _mend(data: dict[str, Any], place: Place) -> None:
    mapping, path = _mapping_at(data, place.path)
    stand_in = _stand_in(place) if path == place.path else None
    if stand_in is not None and mapping.get(path[-1]) != stand_in:
        mapping[path[-1]] = stand_in
    elif path[-1] in mapping:
        del mapping[path[-1]]
    elif len(path) > 1:
        above, path = _mapping_at(data, path[:-1])
        above.pop(path[-1], None)


def _mapping_at(data: Any, path: Path) -> tuple[Any, Path]:
    """Follow a path to the mapping that contains its last entry, or to the first list on the way.

    An item of a list is not removed alone, because the paths of the items after it would change.
    """
    for depth, key in enumerate(path[:-1]):
        inner = data.get(key)
        if not isinstance(inner, dict):
            return data, path[: depth + 1]
        data = inner
    return data, path


def _stand_in(place: Place) -> object:
    """Return a substitute for a required key or quantity; None for anything else."""
    if place.path in _STAND_INS:
        return _STAND_INS[place.path]
    if place.parent is None:
        return None
    field = place.parent.model_fields.get(keys(place.parent).get(str(place.path[-1]), ""))
    if field is None or not field.is_required():
        return None
    quantity = next((mark for mark in field.metadata if isinstance(mark, Quantity)), None)
    return quantity.dimension.example if quantity is not None else None
