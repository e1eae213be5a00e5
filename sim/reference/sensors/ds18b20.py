"""DS18B20: raw codes of 1/16 K (data sheet, "Temperature register format")."""

import math

from heatwright.sim.reference.numbers import by_scale
from heatwright.spec import Board, Ds18b20

converter = by_scale(0.0625)
"""K per code at every resolution: a coarser one leaves the lowest bits zero."""

READ_MARGIN_S = 0.030
"""Time for the nine bytes of the scratchpad and their check, before the control step is due."""

LOWEST_C, HIGHEST_C = -55.0, 125.0


class IdealSensor:
    """A sensor that always answers, with the quantisation of the chip."""

    def __init__(self, sensor: Ds18b20, _board: Board) -> None:
        self._step = 1 << (12 - sensor.resolution_bits)
        self.sampled_before_step_s = sensor.conversion_s + READ_MARGIN_S

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the status, always 0 (valid), and the code nearest to a temperature."""
        limited_c = min(max(temperature_c, LOWEST_C), HIGHEST_C)
        return 0, math.floor(limited_c * 16 / self._step + 0.5) * self._step
