"""JSON Schema of the YAML as written, for editors that complete and check it while it is typed.

It describes one file: keys, kinds, quantities with their units. The loader checks everything that
depends on more than one entry (references, pins, physics).
"""

import math
import re
from collections.abc import Mapping
from decimal import Decimal
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from heatwright.spec.base import Filled, Off
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Checked
from heatwright.spec.programs import Resumes, Within
from heatwright.spec.quantity import Quantity, QuantityRange, amount
from heatwright.spec.units import DIFFERENCE, Dimension

Json = dict[str, Any]

_NUMBER = r"[+\-−]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+\-]?[0-9]{1,2})?"
_NUMBER_WITH_EXPONENT = _NUMBER.removesuffix("?")
LONG = 20
"""A number with more digits, such as 15 ms in days, is left out: nobody would write it so."""
_SPELLINGS = {"μ": "[uµμ]", "Ω": "[ΩΩ]", "2": "[2²]", "°": "°\\s*", "/": "\\s*/\\s*"}
"""Ways to write a character of a unit."""
_BRACKETED = {
    "W/m²K": r"W\s*/\s*\(m[2²][·*]?K\)",
    "W/(m·K)": r"m?W\s*/\s*\(m[·*]?K\)",
    "Ω·mm²/m": r"(Ω|Ω|ohm)[·*]?mm[2²]\s*/\s*m",
    "J/(K·mm)": r"m?J\s*/\s*\(K[·*]?mm\)",
}
"""Ways to write a unit with a product in its denominator."""


def schema() -> Json:
    """Return the JSON Schema of a spec."""
    definitions: dict[str, Json] = {}
    root = _reference(Controller, definitions)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "heatwright",
        "description": "A thermal controller: firmware, simulation and evidence from one file.",
        **root,
        "$defs": dict(sorted(definitions.items())),
    }


def quantity_pattern(dimension: Dimension) -> str:
    """Return a regular expression (ECMA 262) of the quantities of a dimension, unanchored."""
    units = [_spelled(unit) for unit in sorted(dimension.units, key=len, reverse=True)]
    if dimension.base in _BRACKETED:
        units.append(_BRACKETED[dimension.base])
    return rf"{_NUMBER}\s*({'|'.join(units)})"


def _spelled(unit: str) -> str:
    return "".join(_SPELLINGS.get(character, re.escape(character)) for character in unit)


def _choices_pattern(choices: tuple[float, ...], dimension: Dimension) -> str:
    """Return a regular expression of a few quantities; any number with an exponent matches."""
    found = [rf"{_NUMBER_WITH_EXPONENT}\s*({'|'.join(map(_spelled, dimension.units))})"]
    for name, unit in dimension.units.items():
        numbers = [Decimal(str(choice)) / unit.factor + unit.offset for choice in choices]
        digits = "|".join(_digits(each) for each in numbers if len(each.as_tuple().digits) < LONG)
        found += [rf"\+?({digits})\s*{_spelled(name)}"] if digits else []
    return f"({'|'.join(found)})"


def _digits(number: Decimal) -> str:
    """Return a regular expression of the ways to write a number."""
    whole, _, fraction = f"{number.normalize():f}".partition(".")
    whole = whole.lstrip("0")
    return rf"0*{whole}\.{fraction}0*" if fraction else rf"0*{whole}(\.0*)?"


def _model(model: type[BaseModel], definitions: dict[str, Json]) -> Json:
    properties, required = {}, []
    for name, field in model.model_fields.items():
        key = field.alias or name
        properties[key] = _field(field, definitions)
        if field.is_required():
            required.append(key)
    return {
        "type": "object",
        "description": (model.__doc__ or "").splitlines()[0],
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _field(field: FieldInfo, definitions: dict[str, Json]) -> Json:
    annotation: Any = field.annotation
    for mark in field.metadata:
        annotation = Annotated[annotation, mark]
    found = _value(annotation, definitions)
    if field.description:
        found = {"description": field.description, **found}
    default = _default(field)
    return found if default is None else {**found, "default": default}


def _default(field: FieldInfo) -> object:
    """Format a default as it is written in a file; None if there is none worth showing."""
    value = field.default
    quantity = next((mark for mark in field.metadata if isinstance(mark, Quantity)), None)
    if isinstance(quantity, Quantity):
        if value in quantity.words:
            return value
        usable = isinstance(value, int | float) and math.isfinite(value)
        return amount(value, quantity.dimension) if usable else None
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value if isinstance(value, bool | int | float | str) else None


def _reference(model: type[BaseModel], definitions: dict[str, Json]) -> Json:
    name = model.__name__
    if name not in definitions:
        definitions[name] = {}  # reserved first, because a model may refer to itself
        definitions[name] = _model(model, definitions)
    return {"$ref": f"#/$defs/{name}"}


def _value(annotation: Any, definitions: dict[str, Json]) -> Json:
    """Describe the values that an annotation accepts."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _marked(arguments[0], arguments[1:], definitions)
    if origin in (Union, UnionType):
        parts = [_value(part, definitions) for part in arguments if part is not NoneType]
        return parts[0] if len(parts) == 1 else {"anyOf": parts}
    if origin is Literal:
        return {"const": arguments[0]} if len(arguments) == 1 else {"enum": list(arguments)}
    if origin is tuple:
        return _list(arguments, definitions)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {
            "type": "object",
            "propertyNames": _value(arguments[0], definitions),
            "additionalProperties": _value(arguments[1], definitions),
        }
    return _plain(annotation, definitions)


def _plain(annotation: Any, definitions: dict[str, Json]) -> Json:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return _reference(annotation, definitions)
    return {"type": "boolean"} if annotation is bool else {"type": "string"}


def _marked(annotation: Any, marks: tuple[Any, ...], definitions: dict[str, Json]) -> Json:
    for mark in marks:
        if isinstance(mark, Quantity):
            return _quantity(mark)
        if isinstance(mark, Checked):
            return dict(mark.json_schema)
    found = _value(annotation, definitions)
    if Filled in marks:
        found["minProperties"] = 1
    if Within in marks:
        found = {"anyOf": [_quantity(Quantity(DIFFERENCE)), found]}
    if Resumes in marks:
        return {"anyOf": [{"const": "stop"}, found]}
    if Off in marks:
        return {"anyOf": [{"const": "off"}, found]}
    return found


def _quantity(mark: Quantity) -> Json:
    dimension = mark.dimension
    pattern = quantity_pattern(dimension)
    example = dimension.example
    if isinstance(mark, QuantityRange):
        pattern, example = rf"{pattern}\s*\.\.\s*{pattern}", f"{example} .. {example}"
    described: Json = {"type": "string", "pattern": rf"^\s*{pattern}\s*$", "examples": [example]}
    if mark.choices:
        able = [amount(choice, dimension) for choice in mark.choices]
        pattern = rf"^\s*{_choices_pattern(mark.choices, dimension)}\s*$"
        return {"anyOf": [{"enum": able}, {**described, "pattern": pattern, "examples": able}]}
    if mark.words:
        return {"anyOf": [{"enum": list(mark.words)}, described]}
    return described


def _list(arguments: tuple[Any, ...], definitions: dict[str, Json]) -> Json:
    if arguments[-1] is Ellipsis:
        return {"type": "array", "items": _value(arguments[0], definitions)}
    return {
        "type": "array",
        "prefixItems": [_value(argument, definitions) for argument in arguments],
        "minItems": len(arguments),
        "maxItems": len(arguments),
    }
