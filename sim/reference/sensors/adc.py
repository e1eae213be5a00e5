"""Analog sensors: conversion by table, and an ideal sensor (docs/control.md)."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence

from heatwright.sim.circuits import Wiring, pin_v, reference_v, shares
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Analog, Board, Rtd, Thermistor
from heatwright.spec.sensing.conversion import conversion

AnalogSensor = Thermistor | Rtd | Analog

KINDS = ("analog", "rtd", "thermistor")
"""The kinds of sensors that this module serves (spec/registry.py)."""
CODES = 1024
TICK_S = 0.010
VALID, SHORT, OPEN, OUT_OF_RANGE = 0, 2, 17, 18
"""Codes of a reading's status."""


def converter(sensor: AnalogSensor, board: Board) -> Callable[[int], Single]:
    """Return the conversion of a reading to °C: a table, interpolated linearly ("Conversion")."""
    table = conversion(sensor, board.mcu)
    raws = [point.raw for point in table.points]
    celsius = [Single(point.celsius) for point in table.points]
    slopes = [Single(slope) for slope in table.slopes]

    def temperature(raw: int) -> Single:
        place = min(max(bisect_right(raws, raw) - 1, 0), len(raws) - 2)
        return celsius[place] + Single(raw - raws[place]) * slopes[place]

    return temperature


class IdealSensor:
    """A sensor whose codes are all sampled at the same time, in the middle of their real times."""

    def __init__(self, sensor: AnalogSensor, board: Board) -> None:
        """Compute the codes at the ends of the sensor's range, and of the circuit's faults."""
        self._sensor, self._board = sensor, board
        self._known = (math.inf, -math.inf, 0)
        self.sampled_before_step_s = (sensor.oversample + 1) * TICK_S / 2
        self._low, self._high = sorted(self._code(celsius) for celsius in sensor.range_c)
        opened = self._limit(Wiring(opened=True))
        shorted = self._limit(Wiring(shorted=True))
        self._at_low, self._at_high = (OPEN, SHORT) if opened < shorted else (SHORT, OPEN)
        self._far_low = (self._low + min(opened, shorted)) / 2
        self._far_high = (self._high + max(opened, shorted)) / 2

    @property
    def oversample(self) -> int:
        """Number of codes, one per tick, that are summed for a reading."""
        return self._sensor.oversample

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the reading's status and the sum of its codes at a temperature."""
        code = self._code(temperature_c)
        return self._status(code), self._sensor.oversample * code

    def read_all(self, temperatures_c: Sequence[float]) -> tuple[int, int]:
        """Return the status and the sum of codes, with a temperature for each code."""
        codes = [self._code(temperature_c) for temperature_c in temperatures_c]
        status = VALID
        for code in codes:
            status = self._status(code) or status
        return status, sum(codes)

    def _status(self, code: int) -> int:
        if code < self._low:
            return self._at_low if code < self._far_low else OUT_OF_RANGE
        if code > self._high:
            return self._at_high if code > self._far_high else OUT_OF_RANGE
        return VALID

    def _code(self, temperature_c: float) -> int:
        """Return a temperature's code; between two temperatures with one code, compute nothing."""
        low_c, high_c, known = self._known
        if low_c <= temperature_c <= high_c:
            return known
        code = _limited(float(shares(self._sensor, self._board, temperature_c)))
        if code != known:
            low_c = high_c = temperature_c
        self._known = (min(low_c, temperature_c), max(high_c, temperature_c), code)
        return code

    def _limit(self, wiring: Wiring) -> int:
        """Return the circuit's code with a fault of the wiring, the same at any temperature."""
        broken_v = float(pin_v(self._sensor, 0.0, wiring))
        return _limited(broken_v / reference_v(self._sensor, self._board))


def _limited(share: float) -> int:
    return min(max(math.floor(CODES * share), 0), CODES - 1)
