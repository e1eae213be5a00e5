"""Translates pydantic's errors to problems of the file, with reason and remedy."""

from collections.abc import Callable, Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError

from heatwright.spec.loading.shape import Place, keys, kinds, locate
from heatwright.spec.loading.suggest import ELSEWHERE, advice, listed
from heatwright.spec.problems import Path, shown
from heatwright.spec.registry import problem_of_kind

Finding = tuple[Path, str, str]
"""Path, reason, remedy."""

MOST_WORDED = 1000
"""Maximum number of errors that are reported one by one: each suggestion needs time."""
_TOO_MANY = ("this is wrong, too", "Correct the errors above, and check again")


def findings(
    error: ValidationError, root: type[BaseModel], position: Callable[[Path], Any] = len
) -> Iterator[Finding]:
    """Translate all errors of one validation, in the order of their positions in the file."""
    entries = [(locate(root, entry["loc"]), entry) for entry in error.errors(include_url=False)]
    entries.sort(key=lambda each: position(each[0].path))
    # A key of another kind shows that `kind` is wrong: its missing keys are then not reported.
    misfiled = {place.path[:-1] for place, entry in entries if _elsewhere(place, entry)}
    for number, (place, entry) in enumerate(entries):
        if place.path[:-1] in misfiled and not _elsewhere(place, entry):
            continue
        if number >= MOST_WORDED:
            yield place.path, *_TOO_MANY
            continue
        fixed = _FIXED.get(entry["type"])
        if fixed is not None:
            yield place.path, *fixed
        else:
            yield _TRANSLATIONS.get(entry["type"], _other)(place, entry)


def _elsewhere(place: Place, entry: Any) -> str | None:
    """Return what to use instead of a key that belongs to another kind; None if it does not."""
    if entry["type"] != "extra_forbidden" or place.parent is None:
        return None
    return ELSEWHERE.get((place.parent.__name__, str(place.path[-1])))


def _spec(place: Place, entry: Any) -> Finding:
    return place.path, entry["ctx"]["reason"], entry["ctx"]["remedy"]


def _missing(place: Place, _: Any) -> Finding:
    name = keys(place.parent).get(str(place.path[-1])) if place.parent else None
    if place.parent is None or name is None:
        return place.path, "an item is missing here", "Add it"
    about = (place.parent.model_fields[name].description or "").removesuffix(".")
    return place.path, "this key is missing", f"Add it: {about[:1].lower()}{about[1:]}"


def _extra(place: Place, entry: Any) -> Finding:
    word = str(place.path[-1])
    if place.parent is None:
        return place.path, "there are too many items", "Delete it"
    remedy = _elsewhere(place, entry) or advice(word, tuple(keys(place.parent)))
    return place.path, "there is no such key here", remedy


def _no_kind(place: Place, _: Any) -> Finding:
    known = listed(tuple(kinds(place.annotation)))
    return place.path, "this entry has no kind", f"Add kind: {known}"


def _wrong_kind(place: Place, entry: Any) -> Finding:
    word = entry["ctx"]["tag"]
    if problem := problem_of_kind(word):
        return (*place.path, "kind"), f"{shown(word)} is not usable: {problem}", "Fix its package"
    known = tuple(kinds(place.annotation))
    return (*place.path, "kind"), f"{shown(word)} is not a known kind", advice(word, known)


def _literal(place: Place, entry: Any) -> Finding:
    known = _literal_words(place)
    value = entry["input"]
    word = value if isinstance(value, str) else ""
    return place.path, f"{shown(word) if word else 'this'} is not possible", advice(word, known)


def _literal_words(place: Place) -> tuple[str, ...]:
    found: list[str] = []
    stack = [place.annotation]
    while stack:
        annotation = stack.pop()
        if get_origin(annotation) is Literal:
            found += map(str, get_args(annotation))
        else:
            stack += get_args(annotation)
    return tuple(found)


def _other(place: Place, entry: Any) -> Finding:
    return place.path, f"this cannot be read: {entry['msg']}", "Correct it"


_KEYS_NEEDED = ("keys and values are needed here", "Write key: value, one for each line")
_FIXED = {
    "model_type": _KEYS_NEEDED,
    "model_attributes_type": _KEYS_NEEDED,
    "dict_type": _KEYS_NEEDED,
    "mapping_type": _KEYS_NEEDED,
    "tuple_type": ("a list is needed here", "Start each item with a dash, or write [a, b]"),
    "too_long": ("there are too many items", "Delete the last ones"),
    "bool_type": ("yes or no is needed here", "Write true or false"),
}
"""Reason and remedy of errors that need no details, by pydantic's name of the error."""

_TRANSLATIONS: dict[str, Callable[[Place, Any], Finding]] = {
    "spec": _spec,
    "missing": _missing,
    "extra_forbidden": _extra,
    "union_tag_not_found": _no_kind,
    "union_tag_invalid": _wrong_kind,
    "literal_error": _literal,
}
