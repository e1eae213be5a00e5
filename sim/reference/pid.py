"""PID control with filtered derivative and limited integral (docs/control.md, "pid")."""

from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single, clamp, filter_share
from heatwright.spec import Pid


class PidControl:
    """Parallel form, u = P + I + D, in percent of full power."""

    def __init__(self, algorithm: Pid, period_s: float) -> None:
        """Derive the constants."""
        self._kp = Single(algorithm.kp)
        self._integrates = algorithm.ki != 0
        self._ki_step = Single(algorithm.ki * period_s)
        self._integral_limits = (
            Single(algorithm.integral.minimum_percent),
            Single(algorithm.integral.maximum_percent),
        )
        self._holds = algorithm.integral.while_limited == "hold"
        self._differentiates = algorithm.kd != 0
        self._kd = Single(algorithm.kd)
        self._of_error = algorithm.derivative_of == "error"
        self._share = filter_share(period_s, algorithm.derivative_filter_s)
        self._per_period = Single(1 / period_s)
        self._minimum = Single(algorithm.output.minimum_percent)
        self.full_percent = Single(algorithm.output.maximum_percent)
        self.members: tuple[Member, ...] = self._members()
        self._last = ZERO
        self.reset()

    def reset(self) -> None:
        """Start anew after a fault."""
        self._proportional = self._integral = self._derivative = ZERO
        self._started = 0

    def step(self, temperature_c: Single, _last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""
        error = setpoint_c - temperature_c
        if not self._started:
            self._integral = clamp(ZERO, *self._integral_limits) if self._integrates else ZERO
        if self._differentiates and gap == 1:
            slope = self._slope(temperature_c, error)
            self._derivative = self._derivative + self._share * (slope - self._derivative)
        self._proportional = self._kp * error
        candidate = self._integral
        if self._integrates:
            candidate = clamp(self._integral + self._ki_step * error, *self._integral_limits)
        total = self._sum(candidate)
        if self._integrates:
            if self._holds and self._pushes_into_limit(total, error):
                total = self._sum(self._integral)
            else:
                self._integral = candidate
        self._last = error if self._of_error else temperature_c
        self._started = 1
        return clamp(total, self._minimum, self.full_percent)

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        found: tuple[Value, ...] = (self._proportional,)
        if self._integrates:
            found += (self._integral,)
        if self._differentiates:
            found += (self._derivative, self._last)
        if self._integrates or self._differentiates:
            found += (self._started,)
        return found

    def _slope(self, temperature_c: Single, error: Single) -> Single:
        if not self._started:
            return ZERO
        if self._of_error:
            return (error - self._last) * self._per_period
        return -(temperature_c - self._last) * self._per_period

    def _sum(self, integral: Single) -> Single:
        total = self._proportional
        if self._integrates:
            total = total + integral
        if self._differentiates:
            total = total + self._kd * self._derivative
        return total

    def _pushes_into_limit(self, total: Single, error: Single) -> bool:
        if total > self.full_percent:
            return bool(error > ZERO)
        return bool(total < self._minimum and error < ZERO)

    def _members(self) -> tuple[Member, ...]:
        found: tuple[Member, ...] = (("proportional", "f4"),)
        if self._integrates:
            found += (("integral", "f4"),)
        if self._differentiates:
            found += (("derivative", "f4"), ("last", "f4"))
        if self._integrates or self._differentiates:
            found += (("started", "u1"),)
        return found


Control = PidControl
