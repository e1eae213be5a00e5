"""Interfaces: steps that fit the range, baud rates the port can make."""

from __future__ import annotations

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import (
    BUS_BAUDS,
    FASTEST_HOST,
    Gcode,
    LcdKeypad,
    ModbusRtu,
    SerialPlotter,
)
from heatwright.spec.quantity import about, hertz, number
from heatwright.spec.suggest import listed
from heatwright.spec.uart import BAUD_TOLERANCE, baud_setting

USUAL_BAUDS = (9600, 19200, 38400, 57600, 115200, 250000, 500000, 1000000)


def step_fits_range(controller: Controller) -> Findings:
    """Find steps of the keypad larger than the setpoint's range, or finer than the display."""
    for index, interface in enumerate(controller.interfaces):
        if not isinstance(interface, LcdKeypad):
            continue
        path = ("interfaces", index, "step")
        loop = controller.loops.get(interface.loop)
        if round(interface.step_k, 1) != interface.step_k:
            yield Finding(
                path,
                f"{number(interface.step_k)} K is finer than the display, which shows 0.1 °C",
                f"Use {number(round(interface.step_k, 1))} K",
            )
        elif loop is not None:
            range_k = loop.setpoint.maximum_c - loop.setpoint.minimum_c
            if interface.step_k > range_k:
                yield Finding(
                    path,
                    f"a step of {number(interface.step_k)} K is more than the whole range of "
                    f"setpoints, {number(range_k)} K",
                    f"Use at most {number(range_k)} K",
                    (("loops", interface.loop, "setpoint"),),
                )


def baud_can_be_made(controller: Controller) -> Findings:
    """Find baud rates that the clock cannot be divided to."""
    clock_hz = controller.board.clock_hz
    for index, interface in enumerate(controller.interfaces):
        if not isinstance(interface, Gcode | ModbusRtu | SerialPlotter):
            continue
        setting = baud_setting(clock_hz, interface.baud)
        if abs(setting.error) > BAUD_TOLERANCE:
            able = [
                str(baud)
                for baud in _usual(interface)
                if abs(baud_setting(clock_hz, baud).error) <= BAUD_TOLERANCE
            ]
            yield Finding(
                ("interfaces", index, "baud"),
                f"{interface.baud} baud cannot be made from {hertz(clock_hz)}: the "
                f"nearest is {about(setting.baud)}, {about(100 * abs(setting.error))} % off, "
                f"and {number(100 * BAUD_TOLERANCE)} % can be borne",
                f"Use {listed(able)}",
                (("controller",),),
            )


def _usual(interface: Gcode | ModbusRtu | SerialPlotter) -> tuple[int, ...]:
    """List the rates that the other end may offer."""
    if isinstance(interface, ModbusRtu):
        return BUS_BAUDS
    fastest = FASTEST_HOST if isinstance(interface, Gcode) else max(USUAL_BAUDS)
    return tuple(baud for baud in USUAL_BAUDS if baud <= fastest)
