"""Gains of the firmware's PID, and how the forms of the tuning rules become them."""

from __future__ import annotations

from typing import NamedTuple


class Gains(NamedTuple):
    """Parallel form with a filtered derivative: kp + ki/s + kd·s/(filter·s + 1)."""

    kp: float
    """%/K."""
    ki: float
    """%/(K·s)."""
    kd: float
    """%·s/K."""
    filter_s: float
    """Time constant of the derivative, s; without meaning where kd is 0."""
    integral_percent: tuple[float, float] | None = None
    """Limits proposed for the integral, %, where the power that holds is known."""


class Series(NamedTuple):
    """Series form, gain·(1 + 1/(integral·s))·(1 + derivative·s), behind a filter of its input."""

    gain: float
    """%/K."""
    integral_s: float
    derivative_s: float = 0.0

    def parallel(self, filter_s: float) -> Gains:
        """Return the same controller in parallel form.

        gain·(Ti·s + 1)·(Td·s + 1) / (Ti·s·(Tf·s + 1)) in partial fractions. A derivative time below
        the filter's would need a negative kd: then there is nothing to gain from a derivative.
        """
        ki = self.gain / self.integral_s
        if self.derivative_s <= filter_s:
            return Gains(self.gain, ki, 0.0, filter_s)
        kp = ki * (self.integral_s + self.derivative_s - filter_s)
        kd = ki * (self.integral_s - filter_s) * (self.derivative_s - filter_s)
        return Gains(kp, ki, kd, filter_s)
