"""Converts an ADC's codes to temperatures: the firmware's table, and how exact its readings are.

A reading is the sum of `oversample` ten-bit codes. A code stands for the middle of its step, so a
sum stands for the share (sum / oversample + 0.5) / 1024 of the reference. The firmware interpolates
in a table of (sum, °C): the fewest points for which a temperature is nowhere wrong by half a step
of the ADC. Together with the code's own half a step the chain is exact to one step.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

from heatwright.spec.sensing.circuits import Circuit
from heatwright.spec.sensing.fewest import Tube, fewest_points

CODES = 1024
TICK_S = 0.010
"""Time between two codes of a channel: each tick takes one."""

LEAST_MARGIN_STEPS = 2
"""Minimum number of codes between an end of the range and the code of an open or shorted sensor."""

ROUNDINGS = 6
"""Rounding errors in single precision, relative to the largest temperature: one of the point, one
of the sum, and two each of slope and product, which may span twice as much."""


class Point(NamedTuple):
    """One point of the firmware's table."""

    raw: int
    celsius: float
    """Temperature of the point, in single precision."""


class Limits(NamedTuple):
    """Codes of the ADC that separate valid readings from faults.

    low, high -- at the range's ends: a code outside is not valid; low_limit, high_limit -- at the
    circuit's own ends; open_is_high -- whether an open element reads at the upper one.
    """

    low: int
    high: int
    low_limit: int
    high_limit: int
    open_is_high: bool

    @property
    def far_low(self) -> int:
        """Codes below this, halfway from `low` to `low_limit`, mean an open or shorted sensor."""
        return -(-(self.low + self.low_limit) // 2)

    @property
    def far_high(self) -> int:
        """Codes above this, halfway from `high` to `high_limit`, mean an open or shorted sensor."""
        return (self.high + self.high_limit) // 2

    @property
    def shown(self) -> bool:
        """Whether the circuit can show the range, and distinguish an open or shorted sensor."""
        margin = min(self.low - self.low_limit, self.high_limit - self.high)
        return margin >= LEAST_MARGIN_STEPS and self.high - self.low >= LEAST_MARGIN_STEPS


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
        """Kelvins for each count of the sum, from each point to the next, in single precision."""
        return tuple(
            float32((high.celsius - low.celsius) / (high.raw - low.raw))
            for low, high in pairwise(self.points)
        )


def limits(sensor: Any, mcu: str) -> Limits:
    """Find the codes at the ends of an analog sensor's range and circuit, on a chip."""
    chain = sensor.circuit(mcu)
    low, high = sorted(_code(chain.ratio(celsius)) for celsius in sensor.range_c)
    return Limits(low, high, _code(chain.lowest), _code(chain.highest), chain.open_is_high)


@cache
def conversion(sensor: Any, mcu: str) -> Conversion:
    """Compute the table of an analog sensor on a chip.

    Raises ValueError: its circuit does not show the range, so there is nothing to compute a table
    from.
    """
    bounds = limits(sensor, mcu)
    if not bounds.shown:
        raise ValueError("the sensor's range is not within what its circuit can show")
    chain = sensor.circuit(mcu)
    edges = [chain.celsius(code / CODES) for code in range(bounds.low, bounds.high + 2)]
    if hasattr(getattr(sensor, "curve", None), "codes"):
        found = fewest_points(_tube_of_sums(chain, bounds, sensor.oversample))
        apart = 1
    else:
        found, apart = fewest_points(_tube(edges, sensor.oversample)), sensor.oversample
    return Conversion(
        points=tuple(
            Point(sensor.oversample * bounds.low + apart * place, float32(celsius))
            for place, celsius in found
        ),
        limits=bounds,
        step_k=max(abs(high - low) for low, high in pairwise(edges)),
    )


def float32(value: float) -> float:
    """Round once to IEEE single precision, to nearest even."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def _code(ratio: float) -> int:
    """Return the ADC's code at this fraction of the reference voltage."""
    return min(max(math.floor(CODES * ratio), 0), CODES - 1)


def _tube_of_sums(chain: Circuit, bounds: Limits, oversample: int) -> Tube:
    """Bound the table's temperature at each sum.

    A curve that is a table of codes has corners anywhere, and may be ten times as steep after one:
    a line that is right at each code may be wrong between two codes.
    """
    sums = range(oversample * bounds.low, oversample * bounds.high + 1)
    ends_c = [
        sorted(chain.celsius((each / oversample + side) / CODES) for side in (0, 1))
        for each in sums
    ]
    rounding_k = ROUNDINGS * 2.0**-24 * max(abs(end) for ends in ends_c for end in ends)
    return Tube([low + rounding_k for low, _ in ends_c], [high - rounding_k for _, high in ends_c])


def _tube(edges: Sequence[float], oversample: int) -> Tube:
    """Bound the table's temperature at each code by the temperatures at the code's two edges.

    Sums of several readings lie between two codes. There a curve may deviate from its chord by half
    of its second difference at a corner, and by an eighth of it where it is smooth. The bounds are
    narrower by this and by rounding errors.
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
