"""The result of a check, and lists of a controller's parts for the checks."""

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
from heatwright.spec.simulation import Event, ThermalNetwork


class Finding(NamedTuple):
    """One error of the spec, at the key whose change is the best remedy."""

    path: Path
    reason: str
    remedy: str
    because_of: tuple[Path, ...] = ()
    """Other entries that the finding depends on: if one is wrong, the finding may be wrong, too."""


Findings: TypeAlias = Iterator[Finding]
Check: TypeAlias = Callable[[Controller], Findings]
PlantCheck: TypeAlias = Callable[[Controller, ThermalNetwork], Findings]


def loop_sensors(controller: Controller) -> Iterator[tuple[str, Loop, Thermometer]]:
    """List the loops whose sensor exists and shows its whole range, so that it can be checked."""
    for name, loop in controller.loops.items():
        sensor = controller.thermometers.get(loop.sensor)
        if sensor is not None and shows_its_range(sensor, controller.board.mcu):
            yield name, loop, sensor


def loop_types(controller: Controller) -> Iterator[tuple[str, Loop, Thermometer, str]]:
    """List loops as `loop_sensors` does, and again with each other selectable thermocouple type."""
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
    """Return the ADC's codes at the ends of a sensor's range; None if an end has no code."""
    try:
        return limits(sensor, mcu)
    except (ArithmeticError, ValueError):
        return None


def scenario_events(controller: Controller) -> Iterator[tuple[Path, Event]]:
    """List the events of the scenario with their paths; none without a simulation."""
    scenario = controller.simulation.scenario if controller.simulation is not None else ()
    for index, event in enumerate(scenario):
        yield ("simulation", "scenario", index), event


def untaken(  # noqa: PLR0913, PLR0917 - the parts of a finding
    controller: Controller, key: str, field: str, reason: str, remedy: str, because_of: Path
) -> Findings:
    """Report each event of the scenario that has this field: nothing can receive such an event."""
    for path, event in scenario_events(controller):
        if getattr(event, field) is not None:
            yield Finding((*path, key), reason, remedy, (because_of,))


def loop_heaters(controller: Controller) -> Iterator[tuple[str, Loop, Switch]]:
    """List the loops whose heater exists and can heat."""
    for name, loop in controller.loops.items():
        heater = controller.switches.get(loop.heater)
        if heater is not None:
            yield name, loop, heater
