"""From an ADC's codes to temperatures: the firmware's table, and what its readings can mean.

A reading is the sum of `oversample` ten-bit codes. A code stands for the middle of its step, so a
sum for the share (sum / oversample + 0.5) / 1024 of the reference. The firmware interpolates in a
table of (sum, °C): the fewest points for which a temperature is nowhere wrong by half a step of the
ADC. Together with the code's own half a step the chain is exact to one step.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

from heatwright.spec.circuits import Circuit, circuit
from heatwright.spec.fewest import Tube, fewest_points

CODES = 1024
TICK_S = 0.010
"""Each tick takes one code of each channel."""

LEAST_MARGIN_STEPS = 2
"""Between an end of the range and what an open or shorted sensor reads."""

ROUNDINGS = 6
"""Of single precision, as parts of the largest temperature: a point's, the sum's, and of slope and
product, which may span twice as much, two each."""


class Point(NamedTuple):
    """One point of the firmware's table."""

    raw: int
    celsius: float
    """In single precision."""


@dataclass(frozen=True)
class Limits:
    """What sums of codes mean.

    low, high -- of the range's ends: what lies outside is not valid; low_limit, high_limit -- what
    the circuit gives at its own ends; far_low, far_high -- half way to them: below and above these
    the sensor is open or shorted; open_is_high -- which is which; oversample -- codes in a sum.
    """

    low: int
    high: int
    low_limit: int
    high_limit: int
    open_is_high: bool
    oversample: int

    @property
    def far_low(self) -> int:
        """Sums below this are an open or shorted sensor."""
        return -(-(self.low + self.low_limit) // 2)

    @property
    def far_high(self) -> int:
        """Sums above this are an open or shorted sensor."""
        return (self.high + self.high_limit) // 2

    @property
    def low_margin_steps(self) -> int:
        """Steps of the ADC between the range and the circuit's lower end."""
        return (self.low - self.low_limit) // self.oversample

    @property
    def high_margin_steps(self) -> int:
        """Steps of the ADC between the range and the circuit's upper end."""
        return (self.high_limit - self.high) // self.oversample

    @property
    def steps(self) -> int:
        """Steps of the ADC within the range."""
        return (self.high - self.low) // self.oversample


@dataclass(frozen=True)
class Conversion:
    """The firmware's table of a sensor, and how coarse its readings are.

    points -- raw ascending; step_k -- the largest step of the ADC within the range, K.
    """

    points: tuple[Point, ...]
    limits: Limits
    step_k: float

    @property
    def slopes(self) -> tuple[float, ...]:
        """K for each count of the sum, from each point to the next, in single precision."""
        return tuple(
            float32((high.celsius - low.celsius) / (high.raw - low.raw))
            for low, high in pairwise(self.points)
        )


def limits(sensor: Any, mcu: str) -> Limits:
    """Find what the sums of an analog sensor's codes mean."""
    chain, many = circuit(sensor, mcu), sensor.oversample
    ends = sorted(_code(chain.ratio(celsius)) for celsius in sensor.range_c)
    low_limit, high_limit = _code(chain.lowest), _code(chain.highest)
    return Limits(
        low=many * ends[0],
        high=many * ends[1],
        low_limit=many * low_limit,
        high_limit=many * high_limit,
        open_is_high=chain.open_is_high,
        oversample=many,
    )


@cache
def conversion(sensor: Any, mcu: str) -> Conversion:
    """Compute the table of an analog sensor on a chip.

    Raises ValueError for a range that comes within LEAST_MARGIN_STEPS of what the circuit can give,
    or is no two steps long: there is nothing to compute a table from.
    """
    bounds = limits(sensor, mcu)
    margin = min(bounds.low_margin_steps, bounds.high_margin_steps)
    if margin < LEAST_MARGIN_STEPS or bounds.steps < LEAST_MARGIN_STEPS:
        raise ValueError("the sensor's range is not within what its circuit can show")
    edges = _edges(circuit(sensor, mcu), bounds)
    found = fewest_points(_tube(edges, bounds.oversample))
    return Conversion(
        points=tuple(
            Point(bounds.low + bounds.oversample * place, float32(celsius))
            for place, celsius in found
        ),
        limits=bounds,
        step_k=max(abs(high - low) for low, high in pairwise(edges)),
    )


def float32(value: float) -> float:
    """Round once to single precision."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def _code(ratio: float) -> int:
    """Give the code of a share of the reference."""
    return min(max(math.floor(CODES * ratio), 0), CODES - 1)


def _edges(chain: Circuit, bounds: Limits) -> list[float]:
    """List the temperatures between which each code of the range stands, both ends included."""
    first, last = bounds.low // bounds.oversample, bounds.high // bounds.oversample
    return [chain.celsius(code / CODES) for code in range(first, last + 2)]


def _tube(edges: Sequence[float], oversample: int) -> Tube:
    """Bound the table's temperature at each code: half a step to either side are its code's edges.

    Between two codes, where the sums of several readings lie, a curve may leave its chord by half
    of its second difference (at a corner; an eighth where it is smooth). Arithmetic costs some
    roundings of single precision.
    """
    rounding_k = ROUNDINGS * 2.0**-24 * max(abs(edge) for edge in edges)
    bends = [0.0] * (len(edges) - 1)
    if oversample > 1:
        seconds = [abs(a - 2 * b + c) for a, b, c in zip(edges, edges[1:], edges[2:], strict=False)]
        padded = [0.0, *seconds, 0.0, 0.0]
        bends = [max(padded[code : code + 3]) / 2 for code in range(len(edges) - 1)]
    lows, highs = [], []
    for (left, right), bend in zip(pairwise(edges), bends, strict=True):
        room = bend + rounding_k
        lows.append(min(left, right) + room)
        highs.append(max(left, right) - room)
    return Tube(lows, highs)
