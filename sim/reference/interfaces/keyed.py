"""Numbers that the keypad sets (docs/control.md, "Numbers")."""

from collections.abc import Mapping

from heatwright.sim.reference.numbers import Single
from heatwright.spec.adjusted import Number

Numbers = Mapping[str, Single]
"""The numbers that the keypad has set, by field of the algorithm."""


def given(numbers: tuple[Number, ...]) -> dict[str, Single]:
    """Return the spec's values of the numbers that keys may set, by field of the algorithm."""
    return {each.kind.field: Single(each.value) for each in numbers}


def in_range(numbers: tuple[Number, ...], found: Numbers) -> dict[str, Single]:
    """Return the numbers; each that is out of its range is replaced by the spec's."""
    return {
        each.kind.field: found[each.kind.field]
        if Single(each.minimum) <= found[each.kind.field] <= Single(each.maximum)
        else Single(each.value)
        for each in numbers
    }
