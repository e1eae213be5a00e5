"""The resolution of an analog sensor: the size of one ADC step in kelvin.

A chain of divider or amplifier, ADC and table is exact to one step, so this is its error as well.
"""

from functools import cache
from itertools import pairwise
from typing import Any

from heatwright.spec.sensing.circuits import Circuit
from heatwright.spec.sensing.conversion import CODES, limits

COARSEST_MCU = "atmega2560"
"""The chip with the highest internal reference, 2.56 V: its steps are used if no board is given."""

SLOPE_OVER_K = 0.01
"""Difference of temperatures over which a curve is taken as straight, K."""

LEAST_CHANGE = 1e-12
"""Share of the reference below which a change is lost in double precision."""


def step_at_k(sensor: Any, temperature_c: float, mcu: str = COARSEST_MCU) -> float:
    """Return the size of an ADC step in kelvin at a temperature, from the curve's slope there.

    Outside the sensor's range, where no reading is valid, this is the size at the end of the range.
    """
    chain: Circuit = sensor.circuit(mcu)
    low_c, high_c = sensor.range_c
    middle_c = min(max(temperature_c, low_c), high_c)
    below, above = middle_c - SLOPE_OVER_K / 2, middle_c + SLOPE_OVER_K / 2
    change = abs(chain.ratio(above) - chain.ratio(below))
    return SLOPE_OVER_K / (CODES * max(change, LEAST_CHANGE))


@cache
def largest_step_k(sensor: Any, mcu: str = COARSEST_MCU) -> float:
    """Return the size of the largest ADC step in the sensor's range, K."""
    chain: Circuit = sensor.circuit(mcu)
    bounds = limits(sensor, mcu)
    # The ends of the ADC's scale are left out: a curve may have no temperature there.
    last = min(bounds.high + 1, CODES - 1)
    edges = [chain.celsius(code / CODES) for code in range(max(bounds.low, 1), last + 1)]
    return max(abs(high - low) for low, high in pairwise(edges))
