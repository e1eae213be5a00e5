"""Looks up in the models which keys and kinds belong where."""

from collections.abc import Mapping
from functools import cache, lru_cache
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel

from heatwright.spec.problems import Path
from heatwright.spec.registry import kind_of


def kinds(union: Any) -> dict[str, type[BaseModel]]:
    """List the models of a discriminated union by their `kind`, in the order of their writing."""
    return {kind_of(model): model for model in alternatives(union)}


def alternatives(annotation: Any) -> tuple[type[BaseModel], ...]:
    """List the models an annotation allows; none for plain values."""
    if isinstance(annotation, type):
        return (annotation,) if issubclass(annotation, BaseModel) else ()
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, UnionType):
        parts = [part for part in get_args(annotation) if part is not NoneType]
        return tuple(model for part in parts for model in alternatives(part))
    return alternatives(annotation) if isinstance(annotation, type) else ()


@cache
def keys(model: type[BaseModel]) -> dict[str, str]:
    """Map each YAML key of a model to its attribute."""
    return {field.alias or name: name for name, field in model.model_fields.items()}


class Place(NamedTuple):
    """What a location in a pydantic error means: the path in the file, and the type needed."""

    path: Path
    annotation: Any
    parent: type[BaseModel] | None
    """The model to which the last key belongs, or would belong."""


def locate(root: type[BaseModel], location: tuple[str | int, ...]) -> Place:
    """Follow a location in pydantic's errors, which names a union's kind between the keys."""
    return _located(root, location)[0]


@lru_cache(maxsize=1024)  # many errors share the path to their last key
def _followed(root: type[BaseModel], location: tuple[str | int, ...]) -> tuple[Place, bool]:
    return _located(root, location)


def _located(root: type[BaseModel], location: tuple[str | int, ...]) -> tuple[Place, bool]:
    """Follow a location; return also whether its last step was a kind."""
    if not location:
        return Place((), root, None), False
    place, tag_read = _followed(root, location[:-1])
    step = location[-1]
    if step == "[key]":  # the key of a mapping; the step before it led into the mapping
        return place, tag_read
    models = () if tag_read else alternatives(place.annotation)
    if models and _tagged(place):
        chosen = _chosen(place, str(step))
        return Place(place.path, chosen or place.annotation, place.parent), True
    return _enter(place, step), False


def _tagged(place: Place) -> bool:
    models = alternatives(place.annotation)
    by_kind = "kind" in models[0].model_fields and get_origin(place.annotation) is Annotated
    return by_kind or len(models) > 1


def _chosen(place: Place, tag: str) -> type[BaseModel] | None:
    """Find the model of a tag: a kind, or a model's name where keys distinguish the models."""
    models = alternatives(place.annotation)
    if "kind" in models[0].model_fields:
        return kinds(place.annotation).get(tag)
    return next((model for model in models if model.__name__ == tag), None)


def _enter(place: Place, step: str | int) -> Place:
    path = (*place.path, step)
    models = alternatives(place.annotation)
    if models:
        model = models[0]
        field = model.model_fields.get(keys(model).get(str(step), ""))
        if field is None:
            return Place(path, None, model)
        inner: Any = field.annotation
        return Place(path, Annotated[inner, field] if field.discriminator else inner, model)
    return Place(path, _item(place.annotation, step), None)


def _item(annotation: Any, step: str | int) -> Any:
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    arguments = get_args(annotation)
    origin = get_origin(annotation)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return arguments[1]
    if origin is tuple:
        fixed = arguments[-1:] != (Ellipsis,)
        index = step if fixed and isinstance(step, int) and step < len(arguments) else 0
        return arguments[index]
    return None
