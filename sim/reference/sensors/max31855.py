"""MAX31855: signed raw codes of 0.25 K (data sheet, "Thermocouple Temperature Data Format")."""

import math

from heatwright.sim.reference.numbers import by_scale
from heatwright.spec import Board, Max31855

converter = by_scale(0.25)
VALID = 0
LEAST_C, MOST_C = -270.0, 1800.0


class IdealSensor:
    """A sensor that always answers, with the quantisation of the chip."""

    def __init__(self, sensor: Max31855, _board: Board) -> None:
        """Sample one conversion time before the step: its conversion began then or earlier."""
        self.sampled_before_step_s = sensor.conversion_s

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the status, always 0 (valid), and the code nearest to a temperature."""
        return VALID, math.floor(4 * min(max(temperature_c, LEAST_C), MOST_C) + 0.5)
