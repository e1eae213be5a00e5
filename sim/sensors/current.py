"""A heater's current, as a voltage at a pin of the ADC, and how that fails."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import Wiring, current_v
from heatwright.spec import Board, CurrentSensor


class CurrentProbe:
    """A current sensor behind its filter, wired to a channel.

    amperes -- what it says of the current, as its filter lets it through: the mean over the
    heater's pulses; wiring -- what is wrong with it (see Wiring); stands -- it goes on saying what
    it said last, whatever flows.
    """

    def __init__(self, avr: Avr, channel: int, sensor: CurrentSensor) -> None:
        self.amperes = 0.0
        self.stands = False
        self._wiring = Wiring()
        self._avr = avr
        self._channel = channel
        self._sensor = sensor
        self._update()

    def sense(self, amperes: float) -> None:
        """Let this current flow from now on, A."""
        if not self.stands:
            self.amperes = amperes
            self._update()

    @property
    def wiring(self) -> Wiring:
        """What is wrong between sensor and pin."""
        return self._wiring

    @wiring.setter
    def wiring(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self._update()

    def _update(self) -> None:
        voltage_v = float(current_v(self._sensor, self.amperes, self._wiring))
        self._avr.adc.set(self._channel, 1000 * voltage_v)


def attach(avr: Avr, board: Board, sensor: CurrentSensor) -> CurrentProbe:
    """Wire a sound sensor to its pin, and AREF to the reference it needs."""
    channel = board.pins[sensor.pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    if isinstance(sensor.reference, float):
        avr.adc.reference(aref_mv=1000 * sensor.reference, avcc_mv=5000.0)
    return CurrentProbe(avr, channel, sensor)
