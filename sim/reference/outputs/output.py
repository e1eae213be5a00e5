"""Convert the duty of a loop to the counts of its heater (docs/control.md, "Output")."""

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

from heatwright.sim.reference.numbers import ZERO, Kept, Single
from heatwright.spec import Controller, PwmOutput, TimeProportionalOutput
from heatwright.spec.board.timers import allocate
from heatwright.spec.registry import KindIncomplete

HALF = Single(0.5)


class HeaterOutput(Kept, ABC):
    """The conversion of one kind of output, which starts off."""

    counts = 0
    """The on-time, in counts; the maximum is full power."""

    @abstractmethod
    def apply(self, duty_percent: Single) -> None:
        """Take over the duty of a control step."""


class Digital(HeaterOutput):
    """Fully on or off, with no state."""

    def __init__(self) -> None:
        self.keep()

    def apply(self, duty_percent: Single) -> None:
        """Switch on if the duty is above 0, otherwise off."""
        self.counts = int(duty_percent > ZERO)


class PwmPeriod(NamedTuple):
    """Counts of a PWM period, and the least counts of a pulse or a pause."""

    counts: int
    fewest: int


class Pwm(HeaterOutput):
    """On-time in counts of the timer."""

    def __init__(self, period: PwmPeriod, share: float) -> None:
        """Derive the constants; `share` -- share of the time that gives rated power."""
        self.keep(("on_counts", "u2", "counts"))
        self._period = period
        self._per_percent = Single(period.counts * share / 100)

    def apply(self, duty_percent: Single) -> None:
        """Round to the nearest count; too short a pulse or pause becomes none."""
        self.counts = int(duty_percent * self._per_percent + HALF)
        if self.counts < self._period.fewest:
            self.counts = 0
        elif self.counts > self._period.counts - self._period.fewest:
            self.counts = self._period.counts


class TimeProportional(HeaterOutput):
    """On-time in steps of the window's resolution."""

    def __init__(self, output: TimeProportionalOutput) -> None:
        """Derive the window and its shortest on- and off-time, in steps."""
        self.keep(("on_steps", "u2", "counts"))
        self._whole = round(output.window_s / output.resolution_s)
        self._per_percent = Single(self._whole / 100)
        self._least_on = round(output.minimum_on_s / output.resolution_s)
        self._most_on = self._whole - round(output.minimum_off_s / output.resolution_s)

    def apply(self, duty_percent: Single) -> None:
        """Round to the nearest step; too short an on- or off-time becomes none."""
        on_steps = int(duty_percent * self._per_percent + HALF)
        if on_steps < self._least_on:
            on_steps = 0
        elif on_steps > self._most_on:
            on_steps = self._whole
        self.counts = on_steps


def heater_of(controller: Controller, name: str) -> HeaterOutput:
    """Return the conversion of duty to counts for a controller's output."""
    output = controller.outputs[name]
    if isinstance(output, TimeProportionalOutput):
        return TimeProportional(output)
    if isinstance(output, PwmOutput):
        return Pwm(pwm_period(controller, name), rated_share(output))
    if not output.is_on_off:
        raise KindIncomplete(
            f"The output kind {output.kind} has no reference model: a package may provide outputs "
            "that are on or off, and no others."
        )
    return Digital()


def rated_share(output: PwmOutput) -> float:
    """Return the share of the time that gives rated power if the supply gives more."""
    if output.supply_v is None or output.rated_v is None:
        return 1.0
    return (output.rated_v / output.supply_v) ** 2


LATEST_S = 50e-6
"""Longest delay of an interrupt: a pulse made by interrupts is at least this long."""


def pwm_period(controller: Controller, name: str) -> PwmPeriod:
    """Return the counts of a PWM output's period.

    Its timer comes from the spec's allocation. If the timer itself makes the pulses, the counts are
    the finest at the frequency: a 16-bit timer counts to any 16-bit number, an 8-bit timer to 256.
    If interrupts make them, every period on the timer is less than half of its range.
    """
    made = allocate(controller).pwm
    channel = made[name]
    board = controller.board
    timer = board.timers[channel.timer]
    if not channel.by_interrupts and timer.bits == 8:
        return PwmPeriod(256, 0)
    neighbours = [each for each in made if made[each].timer == channel.timer]
    wanted_hz = {each: controller.outputs[each].frequency_hz for each in neighbours}
    limit = 1 << (15 if channel.by_interrupts else 16)
    for prescaler in timer.prescalers:
        counts = {
            each: round(board.clock_hz / (prescaler * wanted_hz[each])) for each in neighbours
        }
        if max(counts.values()) < limit:
            fewest = math.ceil(LATEST_S * board.clock_hz / prescaler)
            return PwmPeriod(counts[name], fewest if channel.by_interrupts else 0)
    raise ValueError(f"{wanted_hz[name]:g} Hz is too slow for timer {channel.timer}")
