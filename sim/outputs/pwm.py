"""An output that is driven by a timer's pulses."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import Board, PwmOutput


def attach(avr: Avr, board: Board, output: PwmOutput) -> Switch:
    """Connect the output to its pin, with the board's resistor to the inactive level."""
    return Switch(avr, board, output.pin, output.active)
