"""How coarse an analog sensor is: what one step of the ADC means in kelvin.

A chain of divider or amplifier, ADC and table is exact to one step, so this is its error as well.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

from heatwright.spec.circuits import circuit
from heatwright.spec.conversion import CODES, limits

COARSEST_MCU = "atmega2560"
"""Of the chips' internal references the highest, 2.56 V: without a board, steps are this wide."""

SLOPE_OVER_K = 0.01
"""Difference of temperatures over which a curve is taken for straight."""


def step_at_k(sensor: Any, temperature_c: float, mcu: str = COARSEST_MCU) -> float:
    """Give the width of an ADC step about a temperature, K, from the slope there."""
    chain = circuit(sensor, mcu)
    below, above = temperature_c - SLOPE_OVER_K / 2, temperature_c + SLOPE_OVER_K / 2
    return SLOPE_OVER_K / (CODES * abs(chain.ratio(above) - chain.ratio(below)))


@cache
def largest_step_k(sensor: Any, mcu: str = COARSEST_MCU) -> float:
    """Give the widest ADC step of the sensor's range, K."""
    bounds, chain = limits(sensor, mcu), circuit(sensor, mcu)
    # The ends of the scale, where a curve may have no temperature, are no part of a step.
    last = min(bounds.high + 1, CODES - 1)
    edges = [chain.celsius(code / CODES) for code in range(max(bounds.low, 1), last + 1)]
    return max(abs(high - low) for low, high in pairwise(edges))
