"""A heater's current, as a voltage at a pin of the ADC, and how that fails."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import current_v
from heatwright.sim.sensors.adc_channel import AdcChannel, channel_of
from heatwright.spec import Board, CurrentSensor


class CurrentProbe(AdcChannel):
    """A current sensor behind its filter, wired to a channel.

    amperes -- what it says of the current, as its filter lets it through: the mean over the
    heater's pulses; wiring -- what is wrong with it (see Wiring); stands -- it goes on saying what
    it said last, whatever flows.
    """

    def __init__(self, avr: Avr, channel: int, sensor: CurrentSensor) -> None:
        self.amperes = 0.0
        self.stands = False
        self._sensor = sensor
        super().__init__(avr, channel)

    def sense(self, amperes: float) -> None:
        """Let this current flow from now on, A."""
        if not self.stands:
            self.amperes = amperes
            self._update()

    def _voltage_v(self) -> float:
        return float(current_v(self._sensor, self.amperes, self._wiring))


def attach(avr: Avr, board: Board, sensor: CurrentSensor) -> CurrentProbe:
    """Wire a sound sensor to its pin."""
    return CurrentProbe(avr, channel_of(avr, board, sensor), sensor)
