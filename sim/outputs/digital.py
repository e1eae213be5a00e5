"""An output that is switched on and off."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import Board, DigitalOutput


def attach(avr: Avr, board: Board, output: DigitalOutput) -> Switch:
    """Connect the output to its pin, with the board's resistor to the inactive level."""
    return Switch(avr, board, output.pin, output.active)
