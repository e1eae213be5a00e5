"""The course of a program's setpoint: segments, hold-back, lag (docs/control.md, "Programs")."""

from heatwright.sim.reference.numbers import LARGEST_COUNT, ZERO, Single, clamp, steps
from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL, Copy, Part
from heatwright.sim.reference.programs.state import (
    FOR_OPERATOR,
    FOR_TARGET,
    HELD_BACK,
    NOTHING,
    ProgramState,
)
from heatwright.spec import Loop, Programs

HALF = Single(0.5)
FEWEST_STEPS, MOST_STEPS = Single(1), Single(16_777_215)
TENTHS_IN_AN_HOUR = 36_000
"""Seconds in an hour, times ten, because rates are stored in 0.1 K/h."""


class Way:
    """Moves the setpoint along the segments of a program."""

    def __init__(self, programs: Programs, loop: Loop) -> None:
        back = programs.hold_back
        self._per_period = self._steps_per_s = Single(1 / loop.period_s)
        self._steps_times_rate = Single(TENTHS_IN_AN_HOUR / loop.period_s)
        self._reached_k = Single(programs.reached_within_k)
        self._lowest_c = Single(loop.protection.minimum_c)
        self._highest_c = Single(loop.protection.maximum_c)
        self._back_k = None if back is None else Single(back.within_k)
        self._limit = min(LARGEST_COUNT, steps(back.limit_s, loop)) if back else 0
        self.copy: Copy = ()

    def begin(self, now: ProgramState, number: int) -> bool:
        """Begin a segment at the present setpoint; return whether there is one."""
        if number > now.segments:
            return False
        part = self.copy[number - 1]
        now.segment = number
        now.from_c = now.setpoint_c
        now.kind, now.to_dc, now.amount = part
        now.elapsed = now.waited = now.segment_clock = 0
        now.waiting = NOTHING
        now.to_c = now.from_c if part.target_c is None else part.target_c
        now.length = self.length(part, now.from_c, now.to_c)
        if part.kind == FAST:
            now.setpoint_c = now.to_c
            now.leap = 1
        return True

    def start_c(self, now: ProgramState, number: int) -> Single:
        """Return the setpoint at the beginning of a segment."""
        targets = [part.target_c for part in self.copy[: number - 1] if part.target_c is not None]
        return targets[-1] if targets else now.first_c

    def length(self, part: Part, from_c: Single, to_c: Single) -> int:
        """Return the steps that a segment takes; 0 if that depends on machine or operator."""
        if part.kind in (OVER, HOLD):
            return max(1, int(Single(part.amount) * self._steps_per_s + HALF))
        if part.kind == RATE:
            number = abs(to_c - from_c) * self._steps_times_rate / Single(part.amount) + HALF
            return int(clamp(number, FEWEST_STEPS, MOST_STEPS))
        return 0

    def is_near(self, temperature_c: Single, setpoint_c: Single) -> bool:
        """Return whether a temperature is near enough to a setpoint."""
        return bool(abs(temperature_c - setpoint_c) <= self._reached_k)

    def go(self, now: ProgramState, temperature_c: Single) -> bool:
        """Advance by a step; return whether the last segment has ended."""
        if now.kind in (OVER, RATE, HOLD) and now.elapsed < now.length:
            self._move(now, temperature_c)
        if now.elapsed != now.length:
            return False
        if now.kind == UNTIL:
            now.waiting = FOR_OPERATOR
        elif now.kind == HOLD or self._is_reached(now, temperature_c):
            return not self.begin(now, now.segment + 1)
        else:
            now.waiting = FOR_TARGET
        return False

    def lags(self, now: ProgramState, temperature_c: Single) -> bool:
        """Return whether the segment has waited too long for a machine that is too cold."""
        waits = now.kind in (OVER, RATE, HOLD) and now.waiting in (HELD_BACK, FOR_TARGET)
        below = waits and now.setpoint_c - temperature_c > ZERO
        if below:
            now.waited = min(now.waited + 1, LARGEST_COUNT)
        return self._back_k is not None and now.waited >= self._limit

    def _move(self, now: ProgramState, temperature_c: Single) -> None:
        lag = now.setpoint_c - temperature_c
        if self._back_k is not None and (lag > self._back_k or lag < -self._back_k):
            now.waiting = HELD_BACK
            return
        now.waiting = NOTHING
        now.elapsed += 1
        new_c = clamp(_setpoint_at(now), self._lowest_c, self._highest_c)
        now.rate_k_per_s = (new_c - now.setpoint_c) * self._per_period
        now.setpoint_c = new_c

    def _is_reached(self, now: ProgramState, temperature_c: Single) -> bool:
        if now.to_c > now.from_c:
            return bool(temperature_c >= now.to_c - self._reached_k)
        if now.to_c < now.from_c:
            return bool(temperature_c <= now.to_c + self._reached_k)
        return self.is_near(temperature_c, now.to_c)


def _setpoint_at(now: ProgramState) -> Single:
    """Return the setpoint after the steps so far."""
    if now.elapsed == now.length:
        return now.to_c
    return now.from_c + (now.to_c - now.from_c) * (Single(now.elapsed) / Single(now.length))
