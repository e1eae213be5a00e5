"""PID control with filtered derivative and limited integral (docs/control.md, "pid")."""

from collections.abc import Iterator

from heatwright.sim.reference.inputs import Gains, Limits
from heatwright.sim.reference.numbers import ZERO, Kept, Single, Value, clamp, faded, filter_share
from heatwright.spec import Loop, Pid
from heatwright.spec.algorithms import Algorithm
from heatwright.spec.facts import LoopFacts

LEAST_RANGE = 1.0
"""Smallest range of the output that may be set, %."""


def limits_of(algorithm: Pid) -> Limits:
    """Return the limits of the spec."""
    return Limits(
        Single(algorithm.integral.minimum_percent),
        Single(algorithm.integral.maximum_percent),
        Single(algorithm.output.maximum_percent),
    )


def limits_given(algorithm: Algorithm) -> Limits | None:
    """Return the limits of an algorithm in the spec; None if none can be set."""
    pid = algorithm.pid
    return limits_of(pid) if pid and pid.limits_adjustable else None


def gains_of(algorithm: Algorithm) -> Gains | None:
    """Return the gains of an algorithm in the spec; None if it has none."""
    pid = algorithm.pid
    return None if pid is None else Gains(Single(pid.kp), Single(pid.ki), Single(pid.kd))


def may_limit(algorithm: Algorithm, limits: Limits) -> bool:
    """Return whether limits are in order, and within those of the spec."""
    pid = algorithm.pid
    return pid is not None and in_order(limits, limits_of(pid), least_maximum_of(pid))


def least_maximum_of(algorithm: Pid) -> Single:
    """Return the lowest maximum of the output that may be set, %."""
    return Single(algorithm.output.minimum_percent + LEAST_RANGE)


def in_order(limits: Limits, widest: Limits, least_maximum: Single) -> bool:
    """Return whether limits are in order, and within the widest."""
    return bool(
        widest.integral_minimum
        <= limits.integral_minimum
        <= limits.integral_maximum
        <= widest.integral_maximum
        and limits.integral_minimum < limits.output_maximum
        and least_maximum <= limits.output_maximum <= widest.output_maximum
    )


class PidControl(Kept):
    """Parallel form, u = P + I + D, in percent of full power."""

    def __init__(self, algorithm: Pid, period_s: float) -> None:
        self._kp = Single(algorithm.kp)
        self._integrates = algorithm.ki != 0
        self._ki_step = Single(algorithm.ki * period_s)
        *self._integral_limits, self.full_percent = limits_of(algorithm)
        self._holds = algorithm.integral.while_limited == "hold"
        self._differentiates = algorithm.kd != 0
        self._kd = Single(algorithm.kd)
        self._of_error = algorithm.derivative_of == "error"
        self._is_late = algorithm.derivative_step == "previous"
        self._share = filter_share(period_s, algorithm.derivative_filter_s)
        self._per_period = Single(1 / period_s)
        self._minimum = Single(algorithm.output.minimum_percent)
        self._band = None if algorithm.band_k is None else Single(algorithm.band_k)
        self._dead_band = Single(algorithm.dead_band_k) if algorithm.dead_band_k else None
        self._keeps = bool(algorithm.dead_band_k) and algorithm.dead_band_keeps == "output"
        self.top_percent = self.full_percent
        """The highest duty under the current's limit; a held integral does not grow above it."""
        self.feed_forward = ZERO
        """Duty for the slope of a program's setpoint, %·s/K."""
        self.rate_k_per_s = ZERO
        """Slope of a program's setpoint in this step."""
        self._show()
        self._last = ZERO
        self.reset()

    def reset(self) -> None:
        """Start again after a fault."""
        self._proportional = self._integral = self._derivative = self._newest = self._kept = ZERO
        self._started = 0

    def step(self, temperature_c: Single, _last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""
        error = self._begin(temperature_c, gap, setpoint_c)
        duty_percent = self._decide(error)
        self._end(temperature_c, error, duty_percent)
        return duty_percent

    def _begin(self, temperature_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Bring the terms up to date and return the error."""
        error = setpoint_c - temperature_c
        if not self._started:
            self._restart_integral()
        if self._differentiates:
            before = self._newest
            if gap == 1:
                slope = self._slope(temperature_c, error)
                self._newest = faded(before + self._share * (slope - before))
            self._derivative = before if self._is_late else self._newest
        self._balance(error)
        self._proportional = self._kp * error
        return error

    def _decide(self, error: Single) -> Single:
        if self._band is not None and (error > self._band or error < -self._band):
            self._restart_integral()
            return self.full_percent if error > self._band else ZERO
        if self._dead_band is not None and -self._dead_band <= error <= self._dead_band:
            if self._keeps:
                return self._limited(self._kept)
            self._proportional = ZERO
            return self._limited(self._sum(self._integral))
        return self._limited(self._integrated(error))

    def _end(self, temperature_c: Single, error: Single, duty_percent: Single) -> None:
        if self._differentiates:
            self._last = error if self._of_error else temperature_c
        if self._integrates or self._differentiates:
            self._started = 1
        if self._keeps:
            self._kept = duty_percent

    def _restart_integral(self) -> None:
        self._integral = clamp(ZERO, *self._integral_limits) if self._integrates else ZERO

    def _balance(self, error: Single) -> None:
        """Keep the sum of the terms when the gains have changed; here they are constant."""

    def _integrated(self, error: Single) -> Single:
        """Integrate, unless the sum would go further beyond a limit, and return the sum."""
        if not self._integrates:
            return self._sum(ZERO)
        candidate = clamp(self._integral + self._ki_step * error, *self._integral_limits)
        total = self._sum(candidate)
        if not (self._holds and self._pushes_into_limit(total, error)):
            self._integral = candidate
        return total

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
        if self.feed_forward:
            total = total + self.feed_forward * self.rate_k_per_s
        return total

    def _limited(self, total: Single) -> Single:
        return clamp(total, self._minimum, self.full_percent)

    def _pushes_into_limit(self, total: Single, error: Single) -> bool:
        if total > min(self.full_percent, self.top_percent):
            return bool(error > ZERO)
        return bool(total < self._minimum and error < ZERO)

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        super().resume(values)
        if not self._is_late:
            self._newest = self._derivative

    def _show(self, *more: tuple[str, str, str]) -> None:
        """Define the members: those of the terms that there are, and more."""
        late = self._differentiates and self._is_late
        self.keep(
            ("proportional", "f4", "_proportional"),
            *[("integral", "f4", "_integral")] * self._integrates,
            *[("derivative", "f4", "_derivative")] * self._differentiates,
            *[("slope", "f4", "_newest")] * late,
            *[("last", "f4", "_last")] * self._differentiates,
            *[("started", "u1", "_started")] * (self._integrates or self._differentiates),
            *[("kept", "f4", "_kept")] * self._keeps,
            *more,
        )


Control = PidControl


class TunablePid(PidControl):
    """PID control that gets its gains at every step; all terms exist, even with a gain of 0."""

    def __init__(self, algorithm: Pid, period_s: float) -> None:
        """Start without gains: the first step sets them."""
        super().__init__(algorithm, period_s)
        self._adjustable = algorithm.limits_adjustable
        self._least_maximum = least_maximum_of(algorithm)
        self.limits = self._widest = limits_of(algorithm)
        """The present limits."""
        self._integrates = self._differentiates = True
        self._period_s = Single(period_s)
        self._kp = self._ki = self._kd = self._ki_step = ZERO
        self._lost = (ZERO, ZERO)
        self._show(*((gain, "f4", f"_{gain}") for gain in Gains._fields))

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        super().resume(values)
        self._ki_step = self._ki * self._period_s

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


def tunable_pid(spec: Loop, facts: LoopFacts) -> TunablePid | None:
    """Return the control of a loop whose gains change; None if its algorithm has none."""
    pid = spec.algorithm.pid
    if pid is None:
        return None
    control = TunablePid(pid, spec.period_s)
    if facts.programmed:
        control.feed_forward = Single(pid.feed_forward)
    return control
