"""Commands of a host or a master to a commanded loop, as events of a scenario."""

from collections.abc import Callable

from heatwright.sim.interfaces.gcode import heats, tunes
from heatwright.spec import Controller, Event, gcode_of, modbus_of

ORDER_S = 1.0
"""Time of the command; a loop that is not commanded starts on its own."""


def heat(controller: Controller, loop: str, target_c: float) -> tuple[Event, ...]:
    """Return the events that heat a loop to a temperature, °C; none if it is not commanded."""
    if modbus_of(controller) is not None:
        return (_written({f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}),)
    return _sent(controller, loop, heats, f"S{target_c:g}")


def tune(controller: Controller, loop: str, target_c: float, cycles: int) -> tuple[Event, ...]:
    """Return the events that tune a loop at a temperature, °C; a master cannot set the cycles."""
    if modbus_of(controller) is not None:
        orders = {f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}
        return (_written({**orders, f"{loop}.tune": True}),)
    return _sent(controller, loop, tunes, f"S{target_c:g} C{cycles}")


def _sent(
    controller: Controller, loop: str, command: Callable[[str], str], words: str
) -> tuple[Event, ...]:
    """Return the event with a command, which depends on the host's address of the loop."""
    gcode = gcode_of(controller)
    called = [name for name, served in gcode.loops.items() if served == loop] if gcode else []
    if not called:
        return ()
    line = f"{command(called[0])} {words}"
    return (Event.model_validate({"at": f"{ORDER_S!r} s", "send": line}),)


def _written(values: dict[str, object]) -> Event:
    return Event.model_validate({"at": f"{ORDER_S!r} s", "write": values})
