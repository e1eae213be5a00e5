"""The safety relay: contacts that weld or never close, and the wire of its mirror contact."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, start_up_s
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.world import Condition, Site, World
from heatwright.sim.native.relay import Armature, Wire
from heatwright.sim.relay import SafetyRelay

CONTACT_S = 0.100
"""Time in which the mirror contact has to follow the relay."""
CLOSES_S = 60.0
"""Within this long, and the first periods, somebody who wants heat has the relay closed."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield what can happen to the relay, if there is one."""
    safety = site.controller.safety
    if safety.relay is None:
        return
    if safety.relay_feedback is None:
        yield from _unseen(site)
        return
    allowed_s = site.loop.next_step_s(CONTACT_S) + TICK_S
    closes_s = CLOSES_S + site.loop.periods_s(starts.FIRST_STEPS)
    stays_open = Trip(("relay_open",), allowed_s, _is_on(safety.relay), closes_s)
    stays_closed = Trip(("relay_welded",), allowed_s + start_up_s(site))
    for name, armature, wire, trip in (
        ("relay_dead", Armature.DEAD, Wire.SOUND, stays_open),
        ("relay_contact_shorted", Armature.SOUND, Wire.SHORTED, stays_open),
        ("relay_welded", Armature.WELDED, Wire.SOUND, stays_closed),
        ("relay_contact_torn", Armature.SOUND, Wire.TORN, stays_closed),
    ):
        yield Fault(
            name,
            lambda: starts.heating(site),
            _breaks(armature, wire, at_start=trip is stays_closed),
            lambda world: _relay(world).fail(),
            trip=trip,
            again=True,
        )


def _unseen(site: Site) -> Iterator[Fault]:
    """Without a contact, a relay that never closes is a heater that gives nothing."""

    def cause(world: World) -> None:
        _relay(world).fail(Armature.DEAD)
        world.set_setpoint(starts.highest_c(site))

    yield Fault(
        "relay_dead",
        lambda: starts.cold(site),
        cause,
        lambda world: _relay(world).fail(),
        watch_s=watch_s(site),
        again=True,
    )


def _breaks(armature: Armature, wire: Wire, *, at_start: bool) -> Act:
    """Break it while it is closed. What looks closed is found when it is next open: at a start."""

    def cause(world: World) -> None:
        _relay(world).fail(armature, wire)
        if at_start:
            world.power_cut()

    return cause


def _is_on(output: str) -> Condition:
    return lambda world: world.device.outputs[output].on


def _relay(world: World) -> SafetyRelay:
    relay = world.device.relay
    assert relay is not None  # noqa: S101 - these faults are of controllers that have one
    return relay


def complaint(world: World, *, floats: bool = False) -> str:
    """Say whether the relay is not open although a fault is latched; "" if all is well.

    floats -- whether its pin may be let go.
    """
    name, relay = world.site.controller.safety.relay, world.device.relay
    if name is None or relay is None:
        return ""
    if world.device.outputs[name].on or not (floats or world.device.outputs[name].driven):
        return f"{name} is not driven to off"
    return "the relay is closed" if relay.closed and relay.armature is Armature.SOUND else ""
