"""Shared by all chips and circuits on an ADC pin: channel, wire, reference.

C takes their voltage from a curve with linear interpolation, because computing the circuit in each
step of time would dominate the run time. The error of a curve is known
(tests/analog/test_conversion.py). Beyond the ends of the curve the circuit itself is computed.
"""

from abc import ABC, abstractmethod

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring
from heatwright.sim.native.analog import Curve
from heatwright.spec import Analog, Board, CurrentSensor, Rtd, Thermistor

Wired = Analog | CurrentSensor | Rtd | Thermistor


class AdcChannel(ABC):
    """A voltage on a channel, by the sensor's value and the faults of its wire."""

    def __init__(self, avr: Avr, channel: int, felt: float) -> None:
        self._wiring = Wiring()
        self._avr = avr
        self.channel = channel
        self._bend(felt)

    @property
    def wiring(self) -> Wiring:
        """The faults between sensor and pin."""
        return self._wiring

    @wiring.setter
    def wiring(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._bend(self.felt)

    @property
    def felt(self) -> float:
        """The sensor's value, in its unit."""
        return self._avr.adc.felt(self.channel)

    @property
    def violations(self) -> dict[str, int]:
        """Return no violations: a voltage has no timing."""
        return {}

    def sense(self, felt: float) -> None:
        """Set the sensor's value from now on."""
        if not self._avr.adc.sense(self.channel, felt):
            self._avr.adc.set(self.channel, 1000 * self._voltage_v(felt))

    def _bend(self, felt: float) -> None:
        """Load the curve of the circuit with its present faults, and set the voltage by it."""
        self._avr.adc.bend(self.channel, self._curve())
        self.sense(felt)

    @abstractmethod
    def _curve(self) -> Curve | None:
        """Return the curve of voltages; None if they depend on more than the sensor's value."""

    @abstractmethod
    def _voltage_v(self, felt: float) -> float:
        """Return the voltage at the pin."""


def channel_of(avr: Avr, board: Board, sensor: Wired) -> int:
    """Return a sensor's channel, and connect AREF to the reference it needs."""
    channel = board.pins[sensor.pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    if isinstance(sensor.reference, float):
        avr.adc.reference(aref_mv=1000 * sensor.reference, avcc_mv=5000.0)
    return channel
