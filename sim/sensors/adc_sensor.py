"""A sensor on a pin of the ADC: a voltage that follows a temperature, and how it fails."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import pin_v
from heatwright.sim.sensors.adc_channel import AdcChannel, channel_of
from heatwright.spec import Analog, Board, Rtd, Thermistor


class AdcSensor(AdcChannel):
    """An analog sensor in its circuit, wired to a channel.

    temperature_c -- what its tip feels, °C; wiring -- what is wrong with it (see Wiring).
    """

    def __init__(self, avr: Avr, channel: int, sensor: Thermistor | Rtd | Analog) -> None:
        self.temperature_c = 20.0
        self._sensor = sensor
        super().__init__(avr, channel)

    def sense(self, temperature_c: float) -> None:
        """Give its tip this temperature from now on, °C."""
        self.temperature_c = temperature_c
        self._update()

    def _voltage_v(self) -> float:
        return float(pin_v(self._sensor, self.temperature_c, self._wiring))


def attach(avr: Avr, board: Board, sensor: Thermistor | Rtd | Analog) -> AdcSensor:
    """Wire a sound sensor to its pin."""
    return AdcSensor(avr, channel_of(avr, board, sensor), sensor)
