"""The numbers of a control step (docs/control.md, "Numbers"), and the members of its state.

Every operation between two `numpy.float32` scalars is one IEEE 754 single-precision operation,
rounded to nearest, ties to even, as gcc's `float`. avr-libc's differs only for some products below
the least normal number.
"""

from collections.abc import Callable, Iterator
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np

from heatwright.spec import Loop

Single = np.float32

ZERO = np.float32(0.0)
FULL = np.float32(100.0)
LEAST_SLOPE = np.float32(1e-9)
"""K/s; a smaller filtered slope counts as 0, before avr-libc's products differ from IEEE 754."""
SECOND_US, TICK_US = 1_000_000, 10_000
LARGEST_COUNT = 65535
"""Counters of steps are 16 bits wide and stay at this maximum."""


def steps(duration_s: float, loop: Loop) -> int:
    """Count the whole control steps in a duration, at least one.

    Both are first rounded to milliseconds: 0.3 s at a period of 0.1 s are 3 steps, although
    0.3 / 0.1 is less than 3 in binary arithmetic.
    """
    return max(1, round(duration_s * 1000) // round(loop.period_s * 1000))


def period(loop: Loop) -> Single:
    """Return a loop's period as the firmware has it, s."""
    return Single(loop.period_s)


def period_us(loop: Loop) -> int:
    """Return a loop's period, µs."""
    return round(loop.period_s * SECOND_US)


def filter_share(period_s: float, filter_s: float) -> Single:
    """Return the share A of a new value in a first-order low-pass y ← y + A·(x − y).

    A = h/(T + h) with period h and time constant T: the backward difference of T·dy/dt + y = x
    (Åström & Hägglund, Advanced PID Control, 2006, chapter 13). T = 0 gives 1: no filter.
    """
    return Single(period_s / (filter_s + period_s))


def by_scale(scale: float) -> Callable[[object, object], Callable[[int], Single]]:
    """Return the `converter` of a kind of sensor whose codes are multiples of a size, K."""
    size = Single(scale)
    return lambda _sensor, _board: lambda raw: Single(raw) * size


def faded(slope: Single) -> Single:
    """Return a filtered slope, K/s, or 0 if it is too small."""
    return ZERO if -LEAST_SLOPE < slope < LEAST_SLOPE else slope


def clamp(value: Single, minimum: Single, maximum: Single) -> Single:
    """Limit a value to a range."""
    if value < minimum:
        return minimum
    if value > maximum:
        return maximum
    return value


Member = tuple[str, str]
"""Name as in docs/control.md and numpy type of its width in the firmware."""

Value = Any
"""An int or a numpy.float32, by the member's type."""


class Kept:
    """A part of the control state."""

    members: tuple[Member, ...]

    def keep(self, *shown: tuple[str, str, str]) -> None:
        """Define the members: name, width, and the attribute that has the value."""
        self.members = tuple((name, width) for name, width, _ in shown)
        self._attributes = tuple(attribute for _, _, attribute in shown)
        self._read = _reader(self._attributes)

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return self._read(self)

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        for attribute in self._attributes:
            holder, _, field = attribute.rpartition(".")
            value = next(values)
            if holder:  # a named tuple
                value = getattr(self, holder)._replace(**{field: value})
            setattr(self, holder or field, value)


@cache
def _reader(attributes: tuple[str, ...]) -> Callable[[object], tuple[Value, ...]]:
    """Return a reader of attributes; for a single one `attrgetter` would not return a tuple."""
    if len(attributes) > 1:
        return attrgetter(*attributes)
    return lambda of: tuple(getattr(of, name) for name in attributes)


def prefixed(prefix: str, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """Put a prefix before the names of members: `heating_steps` → `guard.heating_steps`."""
    return tuple((f"{prefix}.{name}", width) for name, width in members)
