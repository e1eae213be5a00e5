"""Outputs whose current is measured: its healthy value, and the sensor's resolution."""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Switch, full_rms_a
from heatwright.spec.problems import Path
from heatwright.spec.sensing.circuits import reference_v
from heatwright.spec.sensing.conversion import CODES
from heatwright.spec.sensing.currents import Current, CurrentSensor

IDLE_SHARE = 0.05
"""Share of the nominal current below which a reading means no current."""
IDLE_STEPS = 3
"""Steps of the ADC below which a reading means no current."""


class Measured(NamedTuple):
    """An output whose current is measured, with its sensor."""

    name: str
    output: Switch
    current: Current
    sensor: CurrentSensor
    step_a: float
    """One step of the ADC as a root mean square at full duty, A, like limit and trip."""
    highest_a: float
    """Highest current that can be read, A, also as a root mean square at full duty."""

    @property
    def path(self) -> Path:
        """Path of the key `current` in the file."""
        return ("outputs", self.name, "current")

    @property
    def full_a(self) -> float | None:
        """Root mean square of the current at full duty, A; None if it is not known."""
        return full_rms_a(self.output)

    @property
    def idle_a(self) -> float:
        """Current below which a reading means no current, A."""
        return max(IDLE_SHARE * self.current.nominal_a, IDLE_STEPS * self.step_a)


def measured(controller: Controller) -> Iterator[Measured]:
    """List the outputs whose current is measured by a sensor that is defined."""
    for name, output in controller.switches.items():
        if output.current is None:
            continue
        sensor = controller.ammeters.get(output.current.sensor)
        if sensor is not None:
            full_scale_v = reference_v(sensor, controller.board.mcu)
            scale_v_per_a = sensor.scale_v_per_a * output.mean_of_rms
            step_a = full_scale_v / CODES / scale_v_per_a
            highest_a = (CODES - 0.5) * step_a - sensor.offset_v / scale_v_per_a
            yield Measured(name, output, output.current, sensor, step_a, highest_a)
