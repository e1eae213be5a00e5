"""An output with a minimum on- and off-time (docs/control.md, "Output")."""

import math

from heatwright.sim.reference.numbers import TICK_US
from heatwright.spec import DigitalOutput


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
        """Switch off at once, whatever the minimum on-time."""
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
        """Ask for on (1) or off (0), from the next tick that may change it."""
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


def has_minimum(output: DigitalOutput) -> bool:
    """Return whether an output has minimum times."""
    return output.minimum_on_s > 0 or output.minimum_off_s > 0


def held_of(output: DigitalOutput) -> Held:
    """Return the minimum-time model of an output."""
    on_us, off_us = (round(each * 1e6) for each in (output.minimum_on_s, output.minimum_off_s))
    return Held(on_us // TICK_US, off_us // TICK_US)
