"""What a host may command: which loops it serves, and how far."""

from __future__ import annotations

from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Gcode


def gcode_of(controller: Controller) -> Gcode | None:
    """Find the G-code interface of a controller, if it has one."""
    found = (each for each in controller.interfaces if isinstance(each, Gcode))
    return next(found, None)


def commanded(controller: Controller, loop_name: str) -> bool:
    """Tell whether a host sets a loop's setpoint, and may switch it off."""
    gcode = gcode_of(controller)
    return gcode is not None and loop_name in gcode.loops.values()


def tunable(controller: Controller, loop_name: str) -> bool:
    """Tell whether a host sets a loop's gains, and its duty by hand."""
    return commanded(controller, loop_name) and controller.loops[loop_name].algorithm.kind == "pid"
