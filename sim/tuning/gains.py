"""Gains of the firmware's PID, and their conversion from the forms of tuning rules."""

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
    """Time constant of the derivative's filter, s; unused if kd is 0."""
    integral_percent: tuple[float, float] | None = None
    """Limits proposed for the integral, %, if the holding power is known."""


class Series(NamedTuple):
    """Series form, gain·(1 + 1/(integral·s))·(1 + derivative·s), with a filter at its input."""

    gain: float
    """%/K."""
    integral_s: float
    derivative_s: float = 0.0

    def parallel(self, filter_s: float) -> Gains:
        """Return the same controller in parallel form.

        kp, ki and kd: partial fractions of gain·(Ti·s + 1)·(Td·s + 1) / (Ti·s·(Tf·s + 1)). If Td is
        less than Tf, kd would be negative: the derivative is then left out.
        """
        ki = self.gain / self.integral_s
        if self.derivative_s <= filter_s:
            return Gains(self.gain, ki, 0.0, filter_s)
        kp = ki * (self.integral_s + self.derivative_s - filter_s)
        kd = ki * (self.integral_s - filter_s) * (self.derivative_s - filter_s)
        return Gains(kp, ki, kd, filter_s)
