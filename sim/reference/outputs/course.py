"""The state of an output's pin between control steps (docs/control.md, "Output")."""

import math
from typing import Protocol

from heatwright.sim.reference.numbers import TICK_US
from heatwright.sim.reference.outputs.output import pwm_period
from heatwright.spec import Controller, Output, PwmOutput, TimeProportionalOutput
from heatwright.spec.board.timers import TICK_S
from heatwright.spec.outputs import is_held


class Held:
    """An output with minimum times, tick by tick."""

    def __init__(self, minimum_on_ticks: int, minimum_off_ticks: int) -> None:
        """Start off, as after a reset."""
        self._minimum = {True: minimum_on_ticks, False: minimum_off_ticks}
        self._asked = False
        self._stays = minimum_off_ticks
        self.on = False

    def set(self, *, asked: bool) -> None:
        """Request on or off."""
        self._asked = asked

    def stop(self) -> None:
        """Switch off at once, without regard to the minimum on-time."""
        self._asked = False
        self._switch(on=False)

    def tick(self, *, permitted: bool = True) -> bool:
        """Process a tick; return whether the output is on from now on."""
        self._stays = max(0, self._stays - 1)
        wanted = self.on if self._stays else self._asked
        self._switch(on=wanted and permitted)
        return self.on

    def ticks(self, count: int) -> None:
        """Process some ticks of which only the last may change the output: see `changes_in`."""
        if count:
            self._stays = max(0, self._stays - (count - 1))
            self.tick()

    @property
    def changes_in(self) -> float:
        """Number of ticks until the output changes, with the present command."""
        return math.inf if self._asked == self.on else max(1, self._stays)

    def _switch(self, *, on: bool) -> None:
        if on != self.on:
            self.on = on
            self._stays = self._minimum[on]


class HeldCourse:
    """The course of an output with minimum times, with a tick every 10 ms since the start."""

    def __init__(self, held: Held) -> None:
        """Start off."""
        self._held = held
        self._now_us = 0

    def apply(self, counts: int) -> None:
        """Request on (1) or off (0), from the next tick that may change the output."""
        self._held.set(asked=counts > 0)

    def advance(self, to_us: int) -> float:
        """Advance to a time and return for how many microseconds it was on."""
        on_us = 0
        while self._now_us < to_us:
            done = self._now_us // TICK_US
            end_us = round(min(to_us, (done + self._held.changes_in) * TICK_US))
            on_us += (end_us - self._now_us) * self._held.on
            self._now_us = end_us
            self._held.ticks(end_us // TICK_US - done)
        return float(on_us)


def held_of(output: Output) -> Held:
    """Return the minimum-time model of an output."""
    on_us, off_us = (round(each * 1e6) for each in (output.stays_on_s, output.stays_off_s))
    return Held(on_us // TICK_US, off_us // TICK_US)


class Course(Protocol):
    """The course of an output over time; all times in microseconds since the start."""

    def apply(self, counts: int) -> None:
        """Take over the counts of a control step, now."""

    def advance(self, to_us: int) -> float:
        """Advance to a time and return for how many microseconds the output was active."""


class SteadyCourse:
    """A constant share: on or off, or a PWM too fast to simulate its edges."""

    def __init__(self, whole: int) -> None:
        """Start off; `whole` counts are full power."""
        self._whole = whole
        self._share = 0.0
        self._now_us = 0

    def apply(self, counts: int) -> None:
        """Set the share."""
        self._share = counts / self._whole

    def advance(self, to_us: int) -> float:
        """Advance to a time."""
        on_us = (to_us - self._now_us) * self._share
        self._now_us = to_us
        return on_us


class WindowCourse:
    """On for the first part of each window; windows begin with the first control step."""

    def __init__(self, window_us: float, step_us: float) -> None:
        """Start off, without a window."""
        self._window_us = window_us
        self._step_us = step_us
        self._now_us: float = 0
        self._start_us: float = -1
        self._off_us: float = 0
        self._counts = 0

    def apply(self, counts: int) -> None:
        """Set the on-time of windows that begin from now on; zero switches off at once."""
        self._counts = counts
        if self._start_us < 0 or self._now_us == self._start_us:
            self._open()
        if counts == 0:
            self._cut()

    def advance(self, to_us: int) -> float:
        """Advance to a time."""
        if self._start_us < 0:
            self._now_us = to_us
            return 0.0
        on_us: float = 0
        end_us = self._start_us + self._window_us
        if to_us >= end_us:
            on_us = self._on_us(end_us)
            whole = (to_us - end_us) // self._window_us
            on_us += whole * min(self._window_us, self._counts * self._step_us)
            self._now_us = end_us + whole * self._window_us
            self._open()
        on_us += self._on_us(to_us)
        self._now_us = to_us
        return float(on_us)

    def _open(self) -> None:
        """Begin a window."""
        self._start_us = self._now_us
        self._off_us = self._now_us + self._counts * self._step_us

    def _cut(self) -> None:
        """Stay off until the end of the window."""
        self._off_us = min(self._off_us, self._now_us)

    def _on_us(self, to_us: float) -> float:
        """Return the on-time from now to a time in the window."""
        return max(0.0, min(to_us, self._off_us) - self._now_us)


class SpreadCourse(WindowCourse):
    """The on-time of a window in single steps: step s is on if (s · on) mod window < on."""

    def __init__(self, window_steps: int, step_us: int) -> None:
        """Start off, without a window."""
        super().__init__(window_steps * step_us, step_us)
        self._window_steps = window_steps
        self._on_steps = 0

    def _open(self) -> None:
        super()._open()
        self._on_steps = self._counts

    def _cut(self) -> None:
        self._on_steps = 0

    def _on_us(self, to_us: float) -> float:
        return self._on_until(to_us) - self._on_until(self._now_us)

    def _on_until(self, time_us: float) -> float:
        """Return the on-time from the start of the window to a time, with the present counts.

        1 + (n - 1) · on // window of the first n steps are on: step s is on if s · on has passed
        another multiple of the window.
        """
        if not self._on_steps:
            return 0
        step, rest_us = divmod(time_us - self._start_us, self._step_us)
        before = 1 + (step - 1) * self._on_steps // self._window_steps if step else 0
        is_on = step * self._on_steps % self._window_steps < self._on_steps
        return before * self._step_us + (rest_us if is_on else 0)


def course_of(controller: Controller, name: str) -> Course:
    """Return the course of a controller's output, which starts off."""
    output = controller.outputs[name]
    if isinstance(output, TimeProportionalOutput):
        window_us, step_us = round(output.window_s * 1e6), round(output.resolution_s * 1e6)
        if output.distribution == "spread":
            return SpreadCourse(window_us // step_us, step_us)
        return WindowCourse(window_us, step_us)
    if isinstance(output, PwmOutput):
        counts = pwm_period(controller, name).counts
        if output.cycle_s <= TICK_S:
            return SteadyCourse(counts)
        return WindowCourse(output.cycle_s * 1e6, output.cycle_s * 1e6 / counts)
    if is_held(output):
        return HeldCourse(held_of(output))
    return SteadyCourse(1)
