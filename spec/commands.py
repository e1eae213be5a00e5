"""What a host or a master may command: which loops it serves, and how far."""

from __future__ import annotations

from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Gcode, ModbusRtu


def gcode_of(controller: Controller) -> Gcode | None:
    """Find the G-code interface of a controller, if it has one."""
    found = (each for each in controller.interfaces if isinstance(each, Gcode))
    return next(found, None)


def modbus_of(controller: Controller) -> ModbusRtu | None:
    """Find the Modbus interface of a controller, if it has one."""
    found = (each for each in controller.interfaces if isinstance(each, ModbusRtu))
    return next(found, None)


def commanded(controller: Controller, loop_name: str) -> bool:
    """Tell whether a host or a master sets a loop's setpoint, and may switch it off."""
    gcode = gcode_of(controller)
    by_host = gcode is not None and loop_name in gcode.loops.values()
    return by_host or switched(controller, loop_name)


def switched(controller: Controller, loop_name: str) -> bool:
    """Tell whether a loop is enabled and disabled apart from its setpoint: a master serves all."""
    return loop_name in controller.loops and modbus_of(controller) is not None


def zero_is_off(controller: Controller, loop_name: str) -> bool:
    """Tell whether a setpoint of 0 °C switches a loop off, and is no temperature to hold."""
    return commanded(controller, loop_name) and not switched(controller, loop_name)


def tunable(controller: Controller, loop_name: str) -> bool:
    """Tell whether its gains are set by command, and its duty by hand."""
    return commanded(controller, loop_name) and controller.loops[loop_name].algorithm.kind == "pid"
