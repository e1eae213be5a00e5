"""Which rule has to trip, and how soon, for what several faults have in common."""

from __future__ import annotations

from heatwright.sim.faults.bounds import lasting_s, reading_s
from heatwright.sim.faults.conditions import Risen, at_full_power, exceeds, reaches
from heatwright.sim.faults.fault import Trip
from heatwright.sim.faults.world import Site
from heatwright.spec import Loop, OnOff

LONGEST_S = 4 * 3600.0
"""How long a machine may take to meet a condition."""


def full_percent(loop: Loop) -> float:
    """Return the most the loop may ask of its heater, %."""
    return 100.0 if isinstance(loop.algorithm, OnOff) else loop.algorithm.output.maximum_percent


def no_rise(site: Site) -> Trip | None:
    """Full power is asked for, and the reading does not rise: 10, or 9 if that is sooner."""
    loop = site.loop
    bounds = {}
    if loop.protection.heating:
        bounds["heating_failed"] = lasting_s(loop.protection.heating.within_s, loop)
    if loop.protection.frozen:
        bounds["sensor_frozen"] = lasting_s(loop.protection.frozen.for_s, loop)
    if not bounds:
        return None
    rule = min(bounds, key=lambda each: bounds[each])
    return Trip((rule,), bounds[rule], at_full_power(full_percent(loop)), LONGEST_S)


def no_rise_but_moving(site: Site) -> Trip | None:
    """Full power is asked for, and the reading moves but does not rise: 10 alone can tell."""
    loop = site.loop
    if loop.protection.heating is None:
        return None
    allowed_s = lasting_s(loop.protection.heating.within_s, loop)
    due = at_full_power(full_percent(loop))
    return Trip(("heating_failed",), allowed_s, due, LONGEST_S)


def too_hot(site: Site) -> Trip:
    """The reading reaches the maximum."""
    loop = site.loop
    due = reaches(loop.protection.maximum_c)
    return Trip(("over_temperature",), reading_s(loop), due, LONGEST_S)


def rising(site: Site, *, settle_s: float = 0.0) -> Trip | None:
    """The reading rises although the heater is off, and has been for `settle`."""
    rule = site.loop.protection.rising_while_off
    if rule is None:
        return None
    due = Risen(rule.rise_k, settle_s)
    return Trip(("rising_while_off",), reading_s(site.loop), due, LONGEST_S)


def runaway_above(site: Site, setpoint_c: float) -> Trip | None:
    """The reading leaves the band upwards, and stays outside."""
    rule = site.loop.protection.runaway
    if rule is None:
        return None
    allowed_s = lasting_s(rule.for_s, site.loop)
    return Trip(("runaway_above",), allowed_s, exceeds(setpoint_c + rule.above_k), LONGEST_S)
