"""MAX31856: signed raw codes of 1/128 K ("Linearized TC Temperature" in its data sheet)."""

import math

from heatwright.sim.reference.numbers import by_scale
from heatwright.spec import Board, Max31856

converter = by_scale(0.0078125)
RAW = "i4"
"""numpy type of a raw code: it has 19 bits, and all other sensors' codes at most 16."""
VALID, OUT_OF_RANGE = 0, 18
"""Codes of a reading's status."""
STEPS_PER_K = 128
READ_EARLY_S = 0.050
"""How long before a step the result is read."""


class IdealSensor:
    """A sensor that always answers, with the quantisation of the chip."""

    def __init__(self, sensor: Max31856, _board: Board) -> None:
        """Sample one conversion time before the reading: its conversion began then or earlier."""
        self.sampled_before_step_s = sensor.conversion_s + READ_EARLY_S
        self._range_c = sensor.range_c

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the reading's status and the nearest code; its range is that of its type."""
        least_c, most_c = self._range_c
        limited_c = min(max(temperature_c, least_c), most_c)
        status = VALID if limited_c == temperature_c else OUT_OF_RANGE
        return status, math.floor(STEPS_PER_K * limited_c + 0.5)
