"""The interfaces of a controller, the loops that they serve, and the commands that they give."""

from collections.abc import Callable
from typing import TypeVar

from heatwright.spec.base import Model
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import (
    Countdown,
    Gcode,
    Indicators,
    LcdKeypad,
    ModbusRtu,
    Nextion,
    SerialLog,
    SerialPlotter,
)

Kind = TypeVar("Kind", bound=Model)


def placed(controller: Controller, kind: type[Kind]) -> dict[int, Kind]:
    """Find the interfaces of a kind, by their indices; a spec may have only one of most kinds."""
    return {n: each for n, each in enumerate(controller.interfaces) if isinstance(each, kind)}


def _first(kind: type[Kind]) -> Callable[[Controller], Kind | None]:
    """Return a function that finds the first interface of a kind, if a controller has one."""
    return lambda controller: next(iter(placed(controller, kind).values()), None)


gcode_of = _first(Gcode)
keypad_of = _first(LcdKeypad)
log_of = _first(SerialLog)
modbus_of = _first(ModbusRtu)
nextion_of = _first(Nextion)


def for_display(controller: Controller, line: str) -> bool:
    """Return whether a line is for the touch display; beside a host it must begin with a `#`."""
    if nextion_of(controller) is None:
        return False
    return gcode_of(controller) is None or line.startswith("#")


def commanded(controller: Controller, loop_name: str) -> bool:
    """Return whether a host, a master or a person sets a loop's setpoint, and may switch it off."""
    return by_host(controller, loop_name) or switched(controller, loop_name)


def setpoints_c(controller: Controller, loop_name: str) -> tuple[float, float]:
    """Return the lowest and the highest setpoint that a loop may have while it heats, °C."""
    setpoint = controller.loops[loop_name].setpoint
    if commanded(controller, loop_name):
        return setpoint.minimum_c, setpoint.maximum_c
    return setpoint.initial_c, setpoint.initial_c


def by_host(controller: Controller, loop_name: str) -> bool:
    """Return whether a host of G-code commands a loop."""
    gcode = gcode_of(controller)
    return gcode is not None and loop_name in gcode.loops.values()


def switched(controller: Controller, loop_name: str) -> bool:
    """Return whether a loop is enabled and disabled apart from its setpoint.

    A master serves all loops; a keypad, a touch display and programs one each.
    """
    if loop_name not in controller.loops:
        return False
    return modbus_of(controller) is not None or by_hand(controller, loop_name)


def by_hand(controller: Controller, loop_name: str) -> bool:
    """Return whether people switch a loop: by a keypad, a touch display, or starting programs.

    A keypad beside a host switches as the host does, by the setpoint.
    """
    if touched(controller, loop_name) or programmed(controller, loop_name):
        return True
    return keyed(controller, loop_name) and not by_host(controller, loop_name)


def keyed(controller: Controller, loop_name: str) -> bool:
    """Return whether the keypad of the display shield serves a loop."""
    keypad = keypad_of(controller)
    return keypad is not None and keypad.loop == loop_name


def plotted(controller: Controller, loop_name: str) -> bool:
    """Return whether a loop's numbers are sent to a plotter."""
    return any(each.loop == loop_name for each in placed(controller, SerialPlotter).values())


def countdown_of(controller: Controller, loop_name: str) -> Countdown | None:
    """Find the keypad's countdown of a loop: it switches the loop off after a time set by keys."""
    keypad = keypad_of(controller)
    return keypad.countdown if keypad is not None and keypad.loop == loop_name else None


def touched(controller: Controller, loop_name: str) -> bool:
    """Return whether a touch display serves a loop."""
    display = nextion_of(controller)
    return display is not None and display.loop == loop_name


def programmed(controller: Controller, loop_name: str) -> bool:
    """Return whether programs set a loop's setpoint."""
    return controller.programs is not None and controller.programs.loop == loop_name


def starts_enabled(controller: Controller, loop_name: str) -> bool:
    """Return whether a loop is on after the power-up; by default only if nobody can switch it."""
    starts = controller.loops[loop_name].starts
    if starts is None:
        return not switched(controller, loop_name)
    return starts == "enabled"


def zero_is_off(controller: Controller, loop_name: str) -> bool:
    """Return whether a setpoint of 0 °C switches a loop off, and is no temperature to hold."""
    return commanded(controller, loop_name) and not switched(controller, loop_name)


def tunable(controller: Controller, loop_name: str) -> bool:
    """Return whether a command or a program's menu sets a loop's gains, and its duty by hand."""
    has_commands = (
        modbus_of(controller) is not None
        or by_host(controller, loop_name)
        or touched(controller, loop_name)
        or programmed(controller, loop_name)
    )
    return has_commands and controller.loops[loop_name].algorithm.tunable


def shown_loop(controller: Controller, indicators: Indicators) -> str:
    """Name the loop that LEDs show: the loop of their key `loop`, otherwise the only loop."""
    return next(iter(controller.loops)) if indicators.loop is None else indicators.loop


def shown_meanings(controller: Controller, loop_name: str) -> frozenset[str]:
    """Collect the states of a loop that LEDs show."""
    return frozenset(
        meaning
        for each in placed(controller, Indicators).values()
        if shown_loop(controller, each) == loop_name
        for meaning in each.leds.values()
    )
