"""A sensor on an ADC pin: a voltage that follows a temperature, with faults."""

from functools import lru_cache

import numpy as np

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring, pin_v
from heatwright.sim.native.analog import Curve
from heatwright.sim.sensors.adc_channel import AdcChannel, channel_of
from heatwright.spec import Analog, Board, Rtd, Thermistor

KINDS = ("analog", "rtd", "thermistor")
"""The kinds of sensors that this module serves (spec/registry.py)."""
PER_K = 64
"""Points of a curve per kelvin."""
BELOW_K, ABOVE_K = 60, 120
"""How far a curve extends beyond the range of its sensor."""
COLDEST_C = -270


class AdcSensor(AdcChannel):
    """An analog sensor in its circuit, wired to a channel.

    wiring -- its faults (see Wiring).
    """

    def __init__(self, avr: Avr, channel: int, sensor: Thermistor | Rtd | Analog) -> None:
        self._sensor = sensor
        super().__init__(avr, channel, 20.0)

    def _curve(self) -> Curve:
        return curve_of(self._sensor, self._wiring)

    def _voltage_v(self, felt: float) -> float:
        return float(pin_v(self._sensor, felt, self._wiring))


@lru_cache(maxsize=64)
def curve_of(sensor: Thermistor | Rtd | Analog, wiring: Wiring) -> Curve:
    """Return the curve of the pin's voltage over the tip's temperature, °C."""
    low_c, high_c = sensor.range_c
    first_c = max(COLDEST_C, round(low_c) - BELOW_K)
    count = (round(high_c) + ABOVE_K - first_c) * PER_K + 1
    celsius = first_c + np.arange(count) / PER_K
    return Curve(float(first_c), float(PER_K), 1000 * pin_v(sensor, celsius, wiring))


def attach(avr: Avr, board: Board, sensor: Thermistor | Rtd | Analog) -> AdcSensor:
    """Connect a sound sensor to its pin."""
    return AdcSensor(avr, channel_of(avr, board, sensor), sensor)
