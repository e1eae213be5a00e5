"""Sensor of kind `current`: converts pin voltage to A (docs/control.md, "Current")."""

import math

from heatwright.sim.circuits import reference_v
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.spec import Board, CurrentSensor

CODES = 1024
VALID = 0


class Converter:
    """Converts a sum of codes to A."""

    def __init__(self, sensor: CurrentSensor, board: Board) -> None:
        full_v = reference_v(sensor, board)
        self._per_count = Single(full_v / (CODES * sensor.oversample * sensor.scale_v_per_a))
        self._offset = Single((full_v * 0.5 / CODES - sensor.offset_v) / sensor.scale_v_per_a)
        self.step_a = full_v / CODES / sensor.scale_v_per_a
        """One step of the ADC, A."""

    def __call__(self, raw: int) -> Single:
        """Return the current, A."""
        amperes = Single(raw) * self._per_count + self._offset
        return ZERO if amperes < ZERO else amperes


class IdealSensor:
    """A sensor whose codes are all sampled at the same time."""

    def __init__(self, sensor: CurrentSensor, board: Board) -> None:
        """Derive the voltage that is the ADC's full scale."""
        self._sensor = sensor
        self._full_v = reference_v(sensor, board)

    def read(self, amperes: float) -> tuple[int, int]:
        """Return the reading's status and the sum of its codes at a current, A."""
        volts = self._sensor.offset_v + self._sensor.scale_v_per_a * amperes
        code = min(max(math.floor(CODES * volts / self._full_v), 0), CODES - 1)
        return VALID, self._sensor.oversample * code


converter = Converter
