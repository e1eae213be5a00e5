"""Faults of a heater's wire that only its measured current shows."""

from collections.abc import Iterator
from dataclasses import replace

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bounds import reading_s
from heatwright.sim.faults.effects import Heated
from heatwright.sim.faults.fault import Fault, Trip, tripping
from heatwright.sim.faults.machine_parts.currents import SOFT_START, Measured, measured
from heatwright.sim.faults.world import STEP_S, Site, World, given
from heatwright.sim.machine import Heat

BEYOND = 1.2
"""Current of a shorted wire, as a multiple of the current that trips."""
WATCH_S = 30.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the wire of a heater whose current is measured."""
    heater = measured(site)
    if heater is None:
        return
    yield _shorted(site, heater)
    limit_a = heater.limit_a
    if limit_a is None:
        return
    # If a wire's current is larger by this factor, the limit still reduces it at once.
    growth = (limit_a + heater.over_a) / 2 / heater.mean_a
    if SOFT_START * growth < 1:
        yield _part_shorted(site, heater, limit_a)


def _shorted(site: Site, heater: Measured) -> Fault:
    """Return a wire with so little resistance that the current trips at any duty.

    Without an operator the duty of the loop may be below the shortest pulse: no current flows then.
    With an operator, an integral alone may need long for such a duty after the acknowledgement.
    """
    shorted = Heated(site.loop.heater, Heat(once_asked=BEYOND * heater.over_a / heater.mean_a))
    allowed_s = reading_s(site.loop) + STEP_S
    due_s = starts.LONGEST_S if site.is_set else WATCH_S
    trip = Trip(("over_current",), allowed_s, given(site), due_s, certain=site.is_set)
    return replace(tripping(site, "heater_shorted", shorted, trip, shorted.mend), again=True)


def _part_shorted(site: Site, heater: Measured, limit_a: float) -> Fault:
    """Return a wire with too little resistance from the start: the controller limits the duty."""
    times = BEYOND * heater.over_a / heater.mean_a

    def make() -> World:
        world = starts.cold(site)
        Heated(site.loop.heater, effects.weakened(times))(world)
        return world

    def cause(world: World) -> None:
        world.set_setpoint(starts.highest_c(site))

    def held(world: World) -> str:
        log = world.device.steps(world.site.loop_name)
        found_a = float(log["current.amperes"].max())
        asked_a = times * heater.mean_a * float(log["current.applied_percent"].max()) / 100
        if asked_a >= 2 * heater.idle_a and found_a < min(limit_a, asked_a) / 2:
            return f"at most {found_a:.2f} A flowed: too little for the applied duty"
        if found_a >= heater.over_a:
            return f"{found_a:.2f} A flowed, but {heater.over_a:g} A must trip"
        return ""

    return Fault("heater_part_shorted", make, cause, calm=True, watch_s=WATCH_S, judge=held)
