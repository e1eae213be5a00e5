"""An output of the reference device: its counts, and its pin over time, or its feed."""

from collections import deque
from typing import Protocol

from heatwright.sim.reference.numbers import FULL, SECOND_US, ZERO, Single
from heatwright.sim.reference.outputs.course import Course, course_of
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.spec import Controller, Stepper


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


class Feed:
    """A feeding stepper without acceleration ramps, which executes moves one after the other.

    Each is at its own speed, while the feed is permitted.
    """

    def __init__(self, stepper: Stepper, clock: Clock) -> None:
        self._clock = clock
        self._fastest = stepper.maximum_mm_per_s
        self._moves: deque[list[float]] = deque()
        self._place_mm = self._end_mm = self._asked_mm = 0.0
        self._speed = stepper.maximum_mm_per_s
        self._absolute = True
        self._now_us = 0
        self._may_run = False

    def command(self, command: str, to_mm: float | None, mm_per_min: float | None) -> None:
        """Execute G0, G1, G92, M82, M83 or M410."""
        self._go()
        if command in ("M82", "M83"):
            self._absolute = command == "M82"
        elif command == "M410":
            self.forget()
        elif command == "G92" and to_mm is not None:
            self._end_mm = to_mm
        elif command in ("G0", "G1"):
            self._speed = self._speed if mm_per_min is None else mm_per_min / 60
            if to_mm is not None:
                self._move(to_mm - self._end_mm if self._absolute else to_mm)

    def forget(self) -> None:
        """Forget all moves."""
        self._go()
        self._moves = deque()

    def permit(self, *, may_run: bool) -> None:
        """Permit movement from now on, or forbid it."""
        self._go()
        self._may_run = may_run

    def _go(self) -> None:
        """Advance to the present time."""
        to_us = self._clock.now_us
        left_s = (to_us - self._now_us) / SECOND_US if self._may_run else 0.0
        self._now_us = to_us
        while self._moves and left_s > 0:
            move = self._moves[0]
            length_mm, speed = move
            share = min(1.0, left_s * speed / abs(length_mm)) if length_mm else 1.0
            self._place_mm += share * length_mm
            left_s -= share * abs(length_mm) / speed
            move[0] -= share * length_mm
            if share == 1.0:
                self._moves.popleft()

    def travel_mm(self) -> float:
        """Return the feed since the last call, mm; backwards it is negative."""
        self._go()
        travel_mm = self._place_mm - self._asked_mm
        self._asked_mm = self._place_mm
        return travel_mm

    def _move(self, length_mm: float) -> None:
        self._end_mm += length_mm
        speed = min(self._speed, self._fastest)
        if length_mm and speed > 0:
            self._moves.append([length_mm, speed])
