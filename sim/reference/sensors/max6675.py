"""MAX6675: raw codes of 0.25 K from 0 °C (data sheet, "Serial Interface")."""

import math

from heatwright.sim.reference.numbers import by_scale
from heatwright.spec import Board, Max6675

converter = by_scale(0.25)
MOST_CODE = 4095
VALID, NO_ANSWER = 0, 1
"""Codes of a reading's status."""


class IdealSensor:
    """A sensor that always answers, with the quantisation of the chip."""

    def __init__(self, sensor: Max6675, _board: Board) -> None:
        """Sample one conversion time before the step: its conversion began then or earlier."""
        self.sampled_before_step_s = sensor.conversion_s

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the reading's status and the nearest code; 0 °C or less counts as no answer."""
        code = min(max(math.floor(4 * temperature_c + 0.5), 0), MOST_CODE)
        return (VALID if code else NO_ANSWER), code
