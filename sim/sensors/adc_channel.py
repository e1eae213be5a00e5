"""What all chips and circuits on a pin of the ADC share: a channel, a wire, a reference."""

from __future__ import annotations

from abc import ABC, abstractmethod

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring
from heatwright.spec import Analog, Board, CurrentSensor, Rtd, Thermistor

Wired = Analog | CurrentSensor | Rtd | Thermistor


class AdcChannel(ABC):
    """A voltage on a channel, which depends on what its wire has suffered."""

    def __init__(self, avr: Avr, channel: int) -> None:
        self._wiring = Wiring()
        self._avr = avr
        self._channel = channel
        self._update()

    @property
    def wiring(self) -> Wiring:
        """What is wrong between sensor and pin."""
        return self._wiring

    @wiring.setter
    def wiring(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._update()

    @abstractmethod
    def _voltage_v(self) -> float:
        """Return the voltage at the pin now."""

    def _update(self) -> None:
        self._avr.adc.set(self._channel, 1000 * self._voltage_v())


def channel_of(avr: Avr, board: Board, sensor: Wired) -> int:
    """Find a sensor's channel, and wire AREF to the reference it needs."""
    channel = board.pins[sensor.pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    if isinstance(sensor.reference, float):
        avr.adc.reference(aref_mv=1000 * sensor.reference, avcc_mv=5000.0)
    return channel
