"""From the duty of a loop to the counts that its heater is given (docs/control.md, "Output")."""

from typing import Protocol

from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.spec import Controller, PwmOutput, TimeProportionalOutput

HALF = Single(0.5)


class HeaterOutput(Protocol):
    """Counts of one kind of output."""

    members: tuple[Member, ...]
    counts: int
    """The on-time, in counts; all of them are full power."""

    def apply(self, duty_percent: Single) -> None:
        """Take over the duty of a control step."""

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""


class Digital:
    """Fully on or off: the duty says it all."""

    members: tuple[Member, ...] = ()

    def __init__(self) -> None:
        """Start off."""
        self.counts = 0

    def apply(self, duty_percent: Single) -> None:
        """Switch."""
        self.counts = int(duty_percent > ZERO)

    def values(self) -> tuple[Value, ...]:
        """Return nothing."""
        return ()


class Pwm:
    """On-time in counts of the timer."""

    members: tuple[Member, ...] = (("on_counts", "u2"),)

    def __init__(self, whole: int) -> None:
        """Start off; `whole` counts make a PWM period."""
        self._per_percent = Single(whole / 100)
        self.counts = 0

    def apply(self, duty_percent: Single) -> None:
        """Round to the nearest count."""
        self.counts = int(duty_percent * self._per_percent + HALF)

    def values(self) -> tuple[Value, ...]:
        """Return the on-time."""
        return (self.counts,)


class TimeProportional:
    """On-time in steps of the window's resolution."""

    members: tuple[Member, ...] = (("on_steps", "u2"),)

    def __init__(self, output: TimeProportionalOutput) -> None:
        """Derive the window and its shortest on- and off-time, in steps."""
        self._whole = round(output.window_s / output.resolution_s)
        self._per_percent = Single(self._whole / 100)
        self._least_on = round(output.minimum_on_s / output.resolution_s)
        self._most_on = self._whole - round(output.minimum_off_s / output.resolution_s)
        self.counts = 0

    def apply(self, duty_percent: Single) -> None:
        """Round to the nearest step; too short an on- or off-time becomes none."""
        on_steps = int(duty_percent * self._per_percent + HALF)
        if on_steps < self._least_on:
            on_steps = 0
        elif on_steps > self._most_on:
            on_steps = self._whole
        self.counts = on_steps

    def values(self) -> tuple[Value, ...]:
        """Return the on-time."""
        return (self.counts,)


def heater_of(controller: Controller, name: str) -> HeaterOutput:
    """Return the counts of a controller's output."""
    output = controller.outputs[name]
    if isinstance(output, TimeProportionalOutput):
        return TimeProportional(output)
    if isinstance(output, PwmOutput):
        return Pwm(pwm_counts(controller, output))
    return Digital()


def pwm_counts(controller: Controller, output: PwmOutput) -> int:
    """Return the counts of a PWM period.

    The finest that the pin's timer gives at the frequency: a 16-bit timer counts to any end that
    16 bits can say, an 8-bit one to 256.

    Raises:
        ValueError: the pin has no timer, or its timer is too fast for the frequency.

    """
    board = controller.board
    place = board.pins[output.pin].pwm
    if place is None:
        message = f"Pin {output.pin} has no PWM"
        raise ValueError(message)
    timer = board.timers[place[0]]
    if timer.bits == 8:
        return 256
    for prescaler in timer.prescalers:
        found = round(board.clock_hz / (prescaler * output.frequency_hz))
        if found < 1 << timer.bits:
            return found
    message = f"{output.frequency_hz:g} Hz is too slow for pin {output.pin}"
    raise ValueError(message)
