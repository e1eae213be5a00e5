"""Faults of the G-code host: silence, an emergency stop, values out of bounds, a noisy cable."""

from collections.abc import Callable, Iterator

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Fault, Trip, harmless, nothing, tripping
from heatwright.sim.faults.world import Site, World
from heatwright.sim.interfaces.gcode import GcodeHost
from heatwright.sim.interfaces.modbus_rtu import ModbusMaster
from heatwright.sim.lines.serial_noise import SerialNoise
from heatwright.spec import facts_of

WATCH_S = 60.0
ANSWERED_S = 10.0
"""A command that is under way is answered within this time, even over a noisy cable."""
STOP = b"\nM112\n"
BITS_A_BYTE = 10
FLOOD = b"M105\n" * 4000
FLOODED_S = 0.5
"""Longer than it takes to fill the firmware's receive buffers."""
BEYOND_K = 1.0
GARBLED_SHARE = 0.02
"""Share of the bytes that are damaged: it hits about every fourth line."""
LINES = 100
SEED = 3


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults that a host, or the cable to it, can cause on a loop that it commands."""
    host = facts_of(site.controller).gcode
    assert host is not None  # noqa: S101 - a host commands the loop
    after_s = site.loop.protection.master_lost_after_s
    if after_s is not None:
        yield from _silent(site, after_s)
    stopped = Trip(("emergency_stop",), len(STOP) * BITS_A_BYTE / host.baud + 2 * TICK_S)
    yield tripping(site, "host_stop", _stop, stopped)
    yield Fault("host_stop_in_flood", lambda: _flooded(site), _stop, trip=stopped)
    yield harmless(site, "host_out_of_bounds", _exceed_bounds, WATCH_S, _keeps_setpoint)
    yield harmless(site, "host_garbled", _garble, WATCH_S, _hears_all)


def lost(
    site: Site, name: str, after_s: float, part: Callable[[World], ModbusMaster | GcodeHost]
) -> Fault:
    """Return a master or host that becomes silent; it cannot acknowledge until it is back."""
    trip = Trip(("master_lost",), site.loop.next_step_s(after_s) + TICK_S)
    return tripping(
        site, name, lambda world: part(world).unplug(), trip, lambda world: part(world).plug()
    )


def _silent(site: Site, after_s: float) -> Iterator[Fault]:
    """Yield a host that becomes silent, and one that only requests the temperatures."""
    yield lost(site, "host_lost", after_s, lambda world: world.device.host)
    yield harmless(site, "host_only_asks", nothing, after_s + WATCH_S)


def _flooded(site: Site) -> World:
    """Return a world that heats, with more lines waiting than it can ever answer."""
    world = starts.heating(site)
    world.device.host.send_bytes(FLOOD)
    world.run(FLOODED_S)
    return world


def _stop(world: World) -> None:
    """Send M112 directly after the bytes that the firmware has already received."""
    host = world.device.host
    host.unsend()
    host.send_bytes(STOP)


def _exceed_bounds(world: World) -> None:
    """Send setpoints that the spec forbids, and texts that are no numbers."""
    loop = world.site.loop
    beyond = (loop.setpoint.maximum_c + BEYOND_K, loop.protection.maximum_c, 1e6, -BEYOND_K)
    for wanted in (*(f"{each:g}" for each in beyond), "9999999999", "1E3", "nan", "-", ""):
        world.send(f"{world.site.heat_command} S{wanted}")


def _keeps_setpoint(world: World) -> str:
    """Check that the setpoint is unchanged."""
    return starts.setpoint_moved(world, starts.highest_c(world.site))


def _garble(world: World) -> None:
    """Send numbered lines through a cable that damages many of them."""
    world.device.host.noise = SerialNoise(to_board_share=GARBLED_SHARE, seed=SEED)
    for _ in range(LINES):
        world.device.send(f"{world.site.heat_command} S{starts.highest_c(world.site):g}")


def _hears_all(world: World) -> str:
    """Check that every line was done in the end, and that none changed the setpoint."""
    host = world.device.host
    if not world.until(lambda now: not now.device.host.is_busy, ANSWERED_S):
        return "the host still waits for an answer"
    if not host.resends:
        return "the firmware asked for no damaged line again"
    return _keeps_setpoint(world)
