"""Numbers that keys set (docs/control.md, "Numbers")."""

from collections.abc import Mapping

from heatwright.sim.reference.numbers import Single
from heatwright.spec.adjusted import Number

Numbers = Mapping[str, Single]
"""By field of the algorithm."""


def given(numbers: tuple[Number, ...]) -> dict[str, Single]:
    """Return what the specification says."""
    return {each.kind.field: Single(each.value) for each in numbers}


def in_range(numbers: tuple[Number, ...], found: Numbers) -> dict[str, Single]:
    """Return the numbers, and the specification's in the place of each that is out of its range."""
    return {
        each.kind.field: found[each.kind.field]
        if Single(each.minimum) <= found[each.kind.field] <= Single(each.maximum)
        else Single(each.value)
        for each in numbers
    }
