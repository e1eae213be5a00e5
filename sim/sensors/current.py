"""A heater's current sensor with a voltage output on an ADC pin, with faults."""

import numpy as np

from heatwright.sim.avr import Avr
from heatwright.sim.circuits import current_v
from heatwright.sim.circuits.elements import SUPPLY_V
from heatwright.sim.native.analog import Curve
from heatwright.sim.sensors.adc_channel import AdcChannel, channel_of
from heatwright.spec import Board, CurrentSensor


class CurrentProbe(AdcChannel):
    """A current sensor behind its filter, wired to a channel.

    Its input is the output of the filter, the mean over the heater's pulses. wiring -- its faults
    (see Wiring).
    """

    def __init__(self, avr: Avr, channel: int, sensor: CurrentSensor) -> None:
        self._sensor = sensor
        self._stands_at: float | None = None
        super().__init__(avr, channel, 0.0)

    @property
    def amperes(self) -> float:
        """The current that its output shows, A."""
        return self.felt if self._stands_at is None else self._stands_at

    @property
    def stands(self) -> bool:
        """Whether its output stays constant, whatever current flows."""
        return self._stands_at is not None

    @stands.setter
    def stands(self, stands: bool) -> None:
        self._stands_at = self.amperes if stands else None
        self._bend(self.felt)

    def _curve(self) -> Curve | None:
        """Return a line from no current to the current at which the output reaches the supply."""
        if self._stands_at is not None:
            return None
        most_a = (SUPPLY_V - self._sensor.offset_v) / self._sensor.scale_v_per_a
        ends_v = current_v(self._sensor, [0.0, most_a], self._wiring)
        return Curve(0.0, 1 / most_a, np.asarray(1000 * ends_v))

    def _voltage_v(self, felt: float) -> float:
        flows_a = felt if self._stands_at is None else self._stands_at
        return float(current_v(self._sensor, flows_a, self._wiring))


def attach(avr: Avr, board: Board, sensor: CurrentSensor) -> CurrentProbe:
    """Connect a sound sensor to its pin."""
    return CurrentProbe(avr, channel_of(avr, board, sensor), sensor)
