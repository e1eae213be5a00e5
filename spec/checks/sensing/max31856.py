"""Thermocouples at a MAX31856: types that an operator can choose, setpoints within their range."""

import math

from heatwright.spec.checks.finding import Finding, Findings, loop_types
from heatwright.spec.checks.interfaces.displays import NO_MENU
from heatwright.spec.checks.programs.programs import has_an_operator
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.problems import Path
from heatwright.spec.quantity import celsius
from heatwright.spec.sensing.max31856 import Max31856, lowered


def types_have_an_operator(controller: Controller) -> Findings:
    """Find lists of selectable types without an operator, or with fewer than two types."""
    for name, sensor in controller.sensors.items():
        if not isinstance(sensor, Max31856) or not sensor.selectable:
            continue
        path: Path = ("sensors", name, "selectable")
        used_by = [loop for loop, each in controller.loops.items() if each.sensor == name]
        if len(set(sensor.selectable)) < len(sensor.selectable):
            yield Finding(path, "a type is listed twice", "Delete one of them")
        elif sensor.thermocouple not in sensor.selectable:
            yield Finding(
                path,
                f"{sensor.thermocouple}, the type at the start, could not be chosen again",
                f"Add {sensor.thermocouple}",
                (("sensors", name, "thermocouple"),),
            )
        elif len(sensor.selectable) == 1:
            yield Finding(path, "one type leaves no choice", "Add another, or delete selectable")
        elif not any(has_an_operator(controller, loop) for loop in used_by):
            yield Finding(
                path,
                f"nobody could choose a type: {NO_MENU}",
                "Delete it",
                (("interfaces",), ("programs",), ("loops",)),
            )


def setpoints_are_borne(controller: Controller) -> Findings:
    """Find setpoints too hot for the loop's thermocouple, or for another selectable type."""
    for name, loop, sensor, kind in loop_types(controller):
        if not isinstance(sensor, Max31856) or is_lowered(controller, loop, kind):
            continue
        if loop.setpoint.maximum_c > sensor.highest_c:
            or_less = f", or remove {kind} from selectable" if kind else ""
            yield Finding(
                ("loops", name, "setpoint", "maximum"),
                f"{celsius(loop.setpoint.maximum_c)} is too hot for a thermocouple of type "
                f"{sensor.thermocouple}, which is suitable up to {celsius(sensor.highest_c)}",
                f"Use at most {celsius(sensor.highest_c)}{or_less}{or_lower(loop, kind)}",
                (("sensors", loop.sensor),),
            )


def is_lowered(controller: Controller, loop: Loop, kind: str) -> bool:
    """Return whether the firmware lowers the loop's limits while this type is chosen."""
    sensor = controller.sensors[loop.sensor]
    found = lowered(sensor, loop.setpoint.maximum_c, loop.protection.maximum_c)
    least_c = max(loop.setpoint.minimum_c, loop.setpoint.initial_c)  # they cannot be lower
    return loop.protection.maximum_adjustable and found.get(kind, -math.inf) >= least_c


def or_lower(loop: Loop, kind: str) -> str:
    """Offer `maximum_adjustable`, with which the firmware lowers the limit; "" if it is set."""
    if not kind or loop.protection.maximum_adjustable:
        return ""
    return ", or write maximum_adjustable: true, which lowers it while that type is chosen"
