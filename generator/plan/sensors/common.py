"""Common parts of the plans of all sensors."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.spec import Controller, Loop, monitors_of
from heatwright.spec.sensors import Thermometer


@dataclass(frozen=True, slots=True)
class UseOfSensor:
    """How the firmware uses a sensor."""

    period_s: float
    """Shortest period of the loops that read it, s."""
    timer: int | None
    """Number of its own timer; None for a sensor that needs none."""


def raw_type(sensor: Thermometer) -> str:
    """Name the C type of a thermometer's readings."""
    return f"int{sensor.reading_bits}_t"


def current_sensor(controller: Controller, loop: Loop) -> str | None:
    """Name the sensor of the current of a loop's heater, if it has one."""
    current = getattr(controller.outputs[loop.heater], "current", None)
    return None if current is None else str(current.sensor)


def shortest_period_s(controller: Controller, name: str) -> float:
    """Find the shortest period of the loops that read a sensor, also as a monitor's."""
    return min(
        loop.period_s
        for loop_name, loop in controller.loops.items()
        if name in {loop.sensor, current_sensor(controller, loop)}
        or any(name == each.sensor for each in monitors_of(controller, loop_name).values())
    )
