"""PID control whose gains and duty a host may set (docs/control.md, "pid").

All terms exist, even those whose gain is 0 in the spec.
"""

from heatwright.sim.reference.algorithms.pid import (
    PidControl,
    in_order,
    least_maximum_of,
    limits_of,
)
from heatwright.sim.reference.inputs import Gains, Limits
from heatwright.sim.reference.numbers import ZERO, Single, clamp
from heatwright.spec import Pid


class TunablePid(PidControl):
    """PID control that gets its gains at every step."""

    def __init__(self, algorithm: Pid, period_s: float) -> None:
        """Start without gains: the first step sets them."""
        super().__init__(algorithm, period_s)
        self._adjustable = algorithm.limits_adjustable
        self._least_maximum = least_maximum_of(algorithm)
        self.limits = self._widest = limits_of(algorithm)
        """The present limits."""
        self._integrates = self._differentiates = True
        self._period_s = Single(period_s)
        self._kp = self._ki = self._kd = ZERO
        self._lost = (ZERO, ZERO)
        self._show(*((gain, "f4", f"_{gain}") for gain in Gains._fields))

    def take(self, gains: Gains) -> None:
        """Take over the gains for the next step."""
        self._lost = (self._kp - gains.kp, self._kd - gains.kd)
        self._kp, self._ki, self._kd = gains
        self._ki_step = self._ki * self._period_s

    def take_limits(self, limits: Limits | None) -> None:
        """Take over the limits if they are adjustable; others stay as in the spec."""
        if not self._adjustable:
            return
        if limits is None:
            raise ValueError("The loop needs its limits")
        sound = in_order(limits, self._widest, self._least_maximum)
        self.limits = limits if sound else self._widest
        *self._integral_limits, self.full_percent = self.limits

    def follow(self, temperature_c: Single, gap: int, setpoint_c: Single, manual: Single) -> Single:
        """Use the manual duty; set the terms so that the duty does not jump at the return."""
        error = self._begin(temperature_c, gap, setpoint_c)
        duty_percent = self._limited(manual)
        self._integral = clamp(
            duty_percent - self._proportional - self._kd * self._derivative, *self._integral_limits
        )
        self._end(temperature_c, error, duty_percent)
        return duty_percent

    def _balance(self, error: Single) -> None:
        """Correct the integral so that new gains do not change the sum of the terms."""
        lost_kp, lost_kd = self._lost
        if self._started and not (lost_kp == ZERO and lost_kd == ZERO):
            self._integral = clamp(
                self._integral + lost_kp * error + lost_kd * self._derivative,
                *self._integral_limits,
            )
        if self._adjustable:
            self._integral = clamp(self._integral, *self._integral_limits)
