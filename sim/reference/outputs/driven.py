"""An output of the reference device: its counts, and its pin over time."""

from typing import Protocol

from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.outputs.course import Course, course_of
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.spec import Controller


class Clock(Protocol):
    """The device's clock."""

    now_us: int
    """Time since power-up."""


class Driven:
    """An output, with its active time since the last query.

    It is computed only at a query or a change, which is faster.
    """

    def __init__(self, controller: Controller, name: str, clock: Clock) -> None:
        """Start off, or on if the output always runs."""
        self._clock = clock
        self._output = heater_of(controller, name)
        self._course: Course = course_of(controller, name)
        self._asked_us = 0
        self._active_us = 0.0
        self.set(FULL if controller.outputs[name].always_runs else ZERO)

    def set(self, percent: Single) -> None:
        """Set a duty."""
        self._output.apply(percent)
        self.take(self._output.counts)

    def take(self, counts: int) -> None:
        """Set the on-time, in counts that a control step has already computed."""
        self._active_us += self._course.advance(self._clock.now_us)
        self._course.apply(counts)

    def on_fraction(self) -> float:
        """Return the mean active fraction since the last call, 0..1."""
        now_us = self._clock.now_us
        active_us = self._active_us + self._course.advance(now_us)
        self._active_us, elapsed_us = 0.0, now_us - self._asked_us
        self._asked_us = now_us
        return active_us / elapsed_us if elapsed_us else 0.0
