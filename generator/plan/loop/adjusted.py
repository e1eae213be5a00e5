"""Numbers of an algorithm that the keypad sets: their ranges, and their names for the templates."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import facts_of
from heatwright.spec.adjusted import Number


@dataclass(frozen=True, slots=True)
class NumberNames:
    """The names of a loop's number and of its constants in C, and its place in the spec."""

    key: str
    member: str
    unit: str
    title: str
    shown_unit: str
    where: str
    given: str
    minimum: str
    maximum: str
    step: str
    decimals: str


def named(source: Source, name: str, prefix: str) -> list[NumberNames]:
    """Return the names of each number of a loop that the keypad sets."""
    return [
        NumberNames(
            key=each.kind.key,
            member=each.kind.field,
            unit=each.kind.unit,
            title=each.kind.title,
            shown_unit=each.kind.shown_unit,
            where=_at(source, each).where,
            given=_constant(prefix, each, ""),
            minimum=_constant(prefix, each, "_MINIMUM"),
            maximum=_constant(prefix, each, "_MAXIMUM"),
            step=_constant("PANEL", each, "_STEP"),
            decimals=f"PANEL_{each.kind.key.upper()}_DECIMALS",
        )
        for each in facts_of(source.controller, name).keyed_numbers
    ]


def range_constants(source: Source, name: str, prefix: str) -> list[Constant]:
    """Return the constants with the ends of the ranges."""
    return [
        _at(source, each)
        .at(end)
        .number(_constant(prefix, each, f"_{end.upper()}"), value, _shown(each, value))
        for each in facts_of(source.controller, name).keyed_numbers
        for end, value in (("minimum", each.minimum), ("maximum", each.maximum))
    ]


def key_constants(source: Source, name: str) -> list[Constant]:
    """Return the constants of the keypad and the display: the step of a press, and the decimals."""
    found = []
    for each in facts_of(source.controller, name).keyed_numbers:
        at = _at(source, each)
        found += [
            at.at("step").number(
                _constant("PANEL", each, "_STEP"), each.step, _shown(each, each.step)
            ),
            at.count(
                f"PANEL_{each.kind.key.upper()}_DECIMALS", each.decimals, "as many as it needs"
            ),
        ]
    return found


def _at(source: Source, each: Number) -> Source:
    keypad = facts_of(source.controller).keypad
    assert keypad is not None  # noqa: S101 - only keys set numbers
    index = source.controller.interfaces.index(keypad)
    return Source(source.spec, ("interfaces", index, "adjust", each.kind.key))


def _constant(prefix: str, each: Number, what: str) -> str:
    """Name a constant; `what` is put before the number's unit."""
    unit = each.kind.field.removeprefix(each.kind.key)
    return f"{prefix}_{each.kind.key}{what}{unit}".upper()


def _shown(each: Number, value: float) -> str:
    return quantity(value, each.kind.unit)
