"""Faults of the safety relay: contacts weld or never close; its mirror contact's wire breaks."""

from collections.abc import Iterator
from dataclasses import replace

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, start_up_s
from heatwright.sim.faults.fault import Act, Fault, Trip, tripping, watched
from heatwright.sim.faults.world import Condition, Site, World
from heatwright.sim.native.relay import Armature, Wire
from heatwright.sim.relay import SafetyRelay

CONTACT_S = 0.100
"""Time within which the mirror contact must follow the relay."""
CLOSES_S = 60.0
"""The relay closes within this time plus the first periods, if heat is commanded."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the relay, if there is one."""
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
        breaks = _breaks(armature, wire, at_start=trip is stays_closed)
        found = tripping(site, name, breaks, trip, lambda world: _relay(world).fail())
        yield replace(found, again=True)


def _unseen(site: Site) -> Iterator[Fault]:
    """Yield a relay that never closes; without a mirror contact, the heater seems to be broken."""

    def cause(world: World) -> None:
        _relay(world).fail(Armature.DEAD)
        world.set_setpoint(starts.highest_c(site))

    dead = watched(site, "relay_dead", cause, lambda world: _relay(world).fail())
    yield replace(dead, make=lambda: starts.cold(site))


def _breaks(armature: Armature, wire: Wire, *, at_start: bool) -> Act:
    """Break the closed relay; at_start -- cut the power, too, so that the relay has to open."""

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
    """Return a complaint if the relay is not open although a fault is latched, or "".

    floats -- whether its pin may be left undriven.
    """
    name, relay = world.site.controller.safety.relay, world.device.relay
    if name is None or relay is None:
        return ""
    if world.device.outputs[name].on or not (floats or world.device.outputs[name].driven):
        return f"the pin of {name} is not driven to off"
    return "the safety relay is closed" if relay.closed and relay.armature is Armature.SOUND else ""
