"""What a host or a master is made to order of a commanded loop, as events of a scenario."""

from __future__ import annotations

from collections.abc import Callable

from heatwright.sim.interfaces.gcode import heats, tunes
from heatwright.spec import Controller, Event
from heatwright.spec.commands import gcode_of, modbus_of

ORDER_S = 1.0
"""When it is ordered; a controller that nobody commands begins by itself, from the start."""


def heat(controller: Controller, loop: str, target_c: float) -> tuple[Event, ...]:
    """Have a loop heat to a temperature, °C; nothing where nobody commands it."""
    if modbus_of(controller) is not None:
        return (_written({f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}),)
    return _sent(controller, loop, heats, f"S{target_c:g}")


def tune(controller: Controller, loop: str, target_c: float, cycles: int) -> tuple[Event, ...]:
    """Have a loop find its gains at a temperature, °C; a master has no say in the cycles."""
    if modbus_of(controller) is not None:
        orders = {f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}
        return (_written({**orders, f"{loop}.tune": True}),)
    return _sent(controller, loop, tunes, f"S{target_c:g} C{cycles}")


def _sent(
    controller: Controller, loop: str, command: Callable[[str], str], words: str
) -> tuple[Event, ...]:
    """Send a command, which depends on what the host calls the loop, and its words."""
    gcode = gcode_of(controller)
    called = [name for name, served in gcode.loops.items() if served == loop] if gcode else []
    if not called:
        return ()
    line = f"{command(called[0])} {words}"
    return (Event.model_validate({"at": f"{ORDER_S!r} s", "send": line}),)


def _written(values: dict[str, object]) -> Event:
    return Event.model_validate({"at": f"{ORDER_S!r} s", "write": values})
