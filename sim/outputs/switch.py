"""A switch on a pin: a transistor with the board's resistor at its gate."""

from heatwright.sim.avr import Avr
from heatwright.sim.native.pins import Level, Source
from heatwright.spec import Board
from heatwright.spec import Switch as Spec

KINDS = ("digital", "pwm", "time_proportional")
"""The kinds of outputs that this module serves (spec/registry.py)."""


class Switch:
    """A load's switch on a pin, and the time for which it was on.

    A floating pin counts as off because the board's resistor holds the gate at the inactive level;
    without that resistor a heater's state would be random at every reset.
    """

    def __init__(self, avr: Avr, board: Board, pin: str, active: Level) -> None:
        self._avr = avr
        self.pin = board.pins[pin].port_name
        self.active = active
        self._inactive: Level = "low" if active == "high" else "high"
        avr.pins.pull(self.pin, self._inactive)
        self.number = avr.pins.watch(self.pin, logged=False)
        self._cycle = avr.cycle
        self._high = avr.pins.high_cycles(self.number)

    def log_edges(self) -> None:
        """Log its changes from now on; only on request, as a PWM makes many."""
        self._avr.pins.watch(self.pin)

    def on_fraction(self) -> float:
        """Return the share of time it was on since the last call, 0..1; 0 if no time has passed."""
        cycle, high = self._avr.cycle, self._avr.pins.high_cycles(self.number)
        elapsed, on = cycle - self._cycle, high - self._high
        self._cycle, self._high = cycle, high
        if not elapsed:
            return 0.0
        return on / elapsed if self.active == "high" else 1 - on / elapsed

    @property
    def on(self) -> bool:
        """Whether it is on now."""
        return self._avr.pins.level(self.pin) == (self.active == "high")

    @property
    def driven(self) -> bool:
        """Whether the processor, not the board's resistor, sets the level."""
        return self._avr.pins.source(self.pin) is Source.MCU


def attach(avr: Avr, board: Board, output: Spec) -> Switch:
    """Connect an output to its pin, with the board's resistor to the inactive level."""
    return Switch(avr, board, output.pin, output.active)
