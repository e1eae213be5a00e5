"""MAX31865: codes of 15 bits, in parts of the reference resistor (data sheet, "RTD Resistance")."""

import math
from collections.abc import Callable

from heatwright.sim.reference.numbers import Single
from heatwright.spec import Board
from heatwright_max31865.model import Max31865

STEPS = 32768
COEFFICIENTS = tuple(
    map(
        Single,
        (
            -0.021256979, 0.37938112, -2.7641864, 10.770211,
            -23.207612, 37.614804, 218.89442, -241.67988,
        ),
    )
)  # fmt: skip
"""°C by the ratio of the element's resistance to that at 0 °C, the highest power first."""
A, B, C = 3.9083e-3, -5.775e-7, -4.183e-12
"""IEC 60751: R = R0 · (1 + A·t + B·t² + C·(t − 100)·t³), the last of them below 0 °C only."""
VALID, OUT_OF_RANGE = 0, 18
"""Codes of a reading's status."""
READ_EARLY_S = 0.030
"""So long before a step what has been measured is read."""


def converter(sensor: Max31865, _board: Board) -> Callable[[int], Single]:
    """Return what makes °C of a raw code."""
    per_code = Single(sensor.reference_ohm / sensor.ohm_at_0 / STEPS)

    def convert(raw: int) -> Single:
        ratio = Single(raw) * per_code
        celsius = COEFFICIENTS[0]
        for coefficient in COEFFICIENTS[1:]:
            celsius = celsius * ratio + coefficient
        return celsius

    return convert


def ratio_of(temperature_c: float) -> float:
    """Return an element's resistance in parts of that at 0 °C (IEC 60751)."""
    below = C * (temperature_c - 100) * temperature_c**3 if temperature_c < 0 else 0.0
    return 1 + A * temperature_c + B * temperature_c**2 + below


class IdealSensor:
    """A sensor that always answers, with the quantisation of the chip."""

    def __init__(self, sensor: Max31865, _board: Board) -> None:
        """Prepare: the conversion that is read began at least its own length before that."""
        self.sampled_before_step_s = sensor.conversion_s + READ_EARLY_S
        self._range_c = sensor.range_c
        self._codes = STEPS * sensor.ohm_at_0 / sensor.reference_ohm

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the reading's status and the nearest code."""
        least_c, most_c = self._range_c
        limited_c = min(max(temperature_c, least_c), most_c)
        status = VALID if limited_c == temperature_c else OUT_OF_RANGE
        return status, math.floor(self._codes * ratio_of(limited_c) + 0.5)
