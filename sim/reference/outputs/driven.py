"""An output of the reference device: its counts, and what its pin does in time."""

from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.outputs.course import Course, course_of
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.spec import Controller


class Driven:
    """An output with the time it was active since somebody last asked."""

    def __init__(self, controller: Controller, name: str) -> None:
        """Start off, or on if the output always runs."""
        self._output = heater_of(controller, name)
        self._course: Course = course_of(controller, name)
        self._asked_us = self._now_us = 0
        self._active_us = 0.0
        self.set(FULL if controller.outputs[name].always_runs else ZERO)

    def set(self, percent: Single) -> None:
        """Ask for a duty."""
        self._output.apply(percent)
        self._course.apply(self._output.counts)

    def take(self, counts: int) -> None:
        """Take over counts that are known already."""
        self._course.apply(counts)

    def advance(self, to_us: int) -> None:
        """Advance to a time."""
        self._active_us += self._course.advance(to_us)
        self._now_us = to_us

    def on_fraction(self) -> float:
        """Return the mean active fraction since the last call, 0..1."""
        elapsed_us = self._now_us - self._asked_us
        active_us, self._active_us = self._active_us, 0.0
        self._asked_us = self._now_us
        return active_us / elapsed_us if elapsed_us else 0.0
