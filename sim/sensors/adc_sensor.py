"""A sensor on a pin of the ADC: a voltage that follows a temperature, and how it fails."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring, pin_v
from heatwright.spec import Analog, Board, Rtd, Thermistor


class AdcSensor:
    """An analog sensor in its circuit, wired to a channel.

    temperature_c -- what its tip feels, °C; wiring -- what is wrong with it (see Wiring).
    """

    def __init__(self, avr: Avr, channel: int, sensor: Thermistor | Rtd | Analog) -> None:
        self.temperature_c = 20.0
        self._wiring = Wiring()
        self._avr = avr
        self._channel = channel
        self._sensor = sensor
        self._update()

    def sense(self, temperature_c: float) -> None:
        """Give its tip this temperature from now on, °C."""
        self.temperature_c = temperature_c
        self._update()

    @property
    def wiring(self) -> Wiring:
        """What is wrong between element and pin."""
        return self._wiring

    @wiring.setter
    def wiring(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._update()

    def _update(self) -> None:
        voltage_v = float(pin_v(self._sensor, self.temperature_c, self._wiring))
        self._avr.adc.set(self._channel, 1000 * voltage_v)


def attach(avr: Avr, board: Board, sensor: Thermistor | Rtd | Analog) -> AdcSensor:
    """Wire a sound sensor to its pin, and AREF to the reference it needs."""
    channel = board.pins[sensor.pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    if isinstance(sensor.reference, float):
        avr.adc.reference(aref_mv=1000 * sensor.reference, avcc_mv=5000.0)
    return AdcSensor(avr, channel, sensor)
