"""A simulated newsensor at its pins, according to its data sheet."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.spec import Board
from heatwright_newsensor.model import Newsensor as Spec


class Newsensor:
    """A chip on a pin of a processor."""

    def sense(self, temperature_c: float) -> None:
        """Set the temperature of its tip from now on, °C."""
        raise NotImplementedError

    @property
    def violations(self) -> dict[str, int]:
        """Count the violations of the data sheet on its wires, by phase."""
        raise NotImplementedError


def attach(avr: Avr, board: Board, sensor: Spec) -> Newsensor:
    """Put a new chip on the sensor's pin."""
    raise NotImplementedError
