"""What a check finds, and how the checks see a controller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.outputs import Switch
from heatwright.spec.problems import Path
from heatwright.spec.sensing.analog_parts import AnalogSensor
from heatwright.spec.sensing.conversion import Limits, limits
from heatwright.spec.sensing.max31856 import variants
from heatwright.spec.sensors import Thermometer


class Finding(NamedTuple):
    """One thing wrong, at the key that is best changed."""

    path: Path
    reason: str
    remedy: str
    because_of: tuple[Path, ...] = ()
    """Other entries the finding rests on: if one of them is broken, so may be the finding."""


Findings: TypeAlias = Iterator[Finding]
Check: TypeAlias = Callable[[Controller], Findings]


def loop_sensors(controller: Controller) -> Iterator[tuple[str, Loop, Thermometer]]:
    """List the loops whose sensor exists and shows its range: others have no steps to judge."""
    for name, loop in controller.loops.items():
        sensor = controller.thermometers.get(loop.sensor)
        if sensor is not None and shows_its_range(sensor, controller.board.mcu):
            yield name, loop, sensor


def loop_types(controller: Controller) -> Iterator[tuple[str, Loop, Thermometer, str]]:
    """List the same, and once more for each other type of thermocouple that may be chosen."""
    for name, loop, sensor in loop_sensors(controller):
        yield name, loop, sensor, ""
        for kind, chosen in variants(sensor).items():
            if chosen != sensor:
                yield name, loop, chosen, kind


def shows_its_range(sensor: Thermometer, mcu: str) -> bool:
    """Return whether a sensor's readings can be computed all over its range."""
    if not sensor.on_adc:
        return True
    found = limits_of(sensor, mcu)
    return found is not None and found.shown


def limits_of(sensor: AnalogSensor, mcu: str) -> Limits | None:
    """Find what the ADC's codes mean; None where there is no reading at an end of the range."""
    try:
        return limits(sensor, mcu)
    except (ArithmeticError, ValueError):
        return None


def loop_heaters(controller: Controller) -> Iterator[tuple[str, Loop, Switch]]:
    """List the loops whose heater exists and can heat."""
    for name, loop in controller.loops.items():
        heater = controller.switches.get(loop.heater)
        if heater is not None:
            yield name, loop, heater
