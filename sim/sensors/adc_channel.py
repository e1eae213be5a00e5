"""What all chips and circuits on a pin of the ADC share: a channel, a wire, a reference.

Their voltage is taken from a curve, along a straight line between two of its points, in C: to
compute it anew in each step of time would take longer than all else. What a curve lacks to the
circuit is known (tests/analog/test_curves.py). Beyond its ends the circuit itself is computed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring
from heatwright.sim.native.analog import Curve
from heatwright.spec import Analog, Board, CurrentSensor, Rtd, Thermistor

Wired = Analog | CurrentSensor | Rtd | Thermistor


class AdcChannel(ABC):
    """A voltage on a channel, which depends on what is felt and on what its wire has suffered."""

    def __init__(self, avr: Avr, channel: int, felt: float) -> None:
        self._wiring = Wiring()
        self._avr = avr
        self.channel = channel
        self._bend(felt)

    @property
    def wiring(self) -> Wiring:
        """What is wrong between sensor and pin."""
        return self._wiring

    @wiring.setter
    def wiring(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._bend(self.felt)

    @property
    def felt(self) -> float:
        """What it feels, in its unit."""
        return self._avr.adc.felt(self.channel)

    @property
    def violations(self) -> dict[str, int]:
        """None: a voltage is within any data sheet."""
        return {}

    def sense(self, felt: float) -> None:
        """Give it this from now on."""
        if not self._avr.adc.sense(self.channel, felt):
            self._avr.adc.set(self.channel, 1000 * self._voltage_v(felt))

    def _bend(self, felt: float) -> None:
        """Load the present curve of the circuit."""
        self._avr.adc.bend(self.channel, self._curve())
        self.sense(felt)

    @abstractmethod
    def _curve(self) -> Curve | None:
        """Return the voltages by what is felt; None if they depend on more than that."""

    @abstractmethod
    def _voltage_v(self, felt: float) -> float:
        """Return the voltage at the pin."""


def channel_of(avr: Avr, board: Board, sensor: Wired) -> int:
    """Find a sensor's channel, and wire AREF to the reference it needs."""
    channel = board.pins[sensor.pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    if isinstance(sensor.reference, float):
        avr.adc.reference(aref_mv=1000 * sensor.reference, avcc_mv=5000.0)
    return channel
