"""Which parameters the record determines, and which it cannot."""

import math
from typing import NamedTuple

import numpy as np

from heatwright.sim.identify.record import Record
from heatwright.sim.identify.residuals import noise, pattern
from heatwright.sim.identify.structure import AMBIENT_C, DELAY, LAG, Parameter, Structure
from heatwright.sim.trace import Series
from heatwright.spec.quantity import about

FIRST = 5
"""Number of rows whose median is the temperature at the record's beginning."""
COLDER_K = 2.0
"""A machine that was off for long cannot be colder than the ambient by more than this."""


class Found(NamedTuple):
    """A parameter, its 95 % interval, and whether the record determines it."""

    parameter: Parameter
    value: float
    low: float
    high: float
    """Infinite if the record sets no upper limit."""
    told: bool
    given: bool = False
    """Given by the user, not fitted."""


def findings(
    structure: Structure, values: Series, halves: Series, record: Record, *, ambient_given: bool
) -> tuple[Found, ...]:
    """Return every parameter with its interval, and whether the record determines it."""
    moved_k = float(np.ptp(record.readings_c))
    found = []
    for parameter, value, half in zip(
        structure.parameters, values.tolist(), halves.tolist(), strict=True
    ):
        given = ambient_given and parameter.key == AMBIENT_C
        low, high = _ends(parameter, value, half)
        told = given or _told(parameter, low, half, moved_k)
        found.append(Found(parameter, value, low, high, told, given))
    return tuple(found)


def _ends(parameter: Parameter, value: float, half: float) -> tuple[float, float]:
    if not parameter.logarithmic:
        low = value - half
        return (max(0.0, low) if parameter.key in {LAG, DELAY} else low), value + half
    try:
        factor = math.exp(half)
    except OverflowError:
        factor = math.inf
    return value / factor, value * factor


def _told(parameter: Parameter, low: float, half: float, moved_k: float) -> bool:
    """Return whether the record determines the parameter.

    Heat capacity and resistance: the interval ends within a factor of e. Lag and dead time: 0 is
    outside it. Ambient: half of the interval is narrower than the movement of the record.
    """
    if parameter.logarithmic:
        return half < 1
    return half < moved_k if parameter.key == AMBIENT_C else low > 0


def warnings(
    found: tuple[Found, ...], residuals_k: Series, record: Record, structure: Structure
) -> tuple[str, ...]:
    """Return the warnings that the user needs before using the numbers."""
    said = [_untold(each) for each in found if not each.told]
    begins_c = float(np.median(record.readings_c[:FIRST]))
    said += [
        f"the machine would have begun at {about(begins_c)} °C, colder than the ambient of "
        f"{about(each.value)} °C; if the machine was at ambient when the record began, use --cold, "
        "or give the ambient (--ambient)"
        for each in found
        if each.parameter.key == AMBIENT_C and not each.given and each.low > begins_c + COLDER_K
    ]
    rest_k = pattern(residuals_k)
    if rest_k > max(record.resolution_k, noise(residuals_k)):
        remedy = "try --bodies 2" if structure.bodies == 1 else "look at the picture (--plot)"
        said.append(
            f"the machine differs from this model: {about(rest_k)} K of the error has a "
            f"pattern that noise does not explain, and the intervals do not include it; {remedy}"
        )
    return (*said, *record.notes)


def _untold(each: Found) -> str:
    title, unit = each.parameter.title, each.parameter.unit
    if each.parameter.key in {LAG, DELAY}:
        return (
            f"the {title} may be 0, and is at most {about(each.high)} {unit}; more "
            "lines around a step would show it"
        )
    if each.parameter.key == AMBIENT_C:
        return "this record does not show the ambient; measure it and give it: --ambient 20C"
    remedy = "record until the temperature hardly rises, or give the ambient (--ambient)"
    if each.parameter.key.startswith("capacity"):
        remedy = "record a step from a constant temperature, with more lines while it rises"
    return f"this record does not show the {title}; {remedy}"
