"""Which rule has to trip, and how soon, for what several faults have in common."""

from __future__ import annotations

from dataclasses import replace

from heatwright.sim.faults.bounds import lasting_s, reading_s
from heatwright.sim.faults.conditions import Risen, at_full_power, exceeds, reaches
from heatwright.sim.faults.fault import Trip, at_once
from heatwright.sim.faults.machine import blur_k
from heatwright.sim.faults.world import Condition, Site
from heatwright.spec import Loop, Pid

LONGEST_S = 4 * 3600.0
"""How long a machine may take to meet a condition."""


def full_percent(loop: Loop) -> float:
    """Return the most the loop may ask of its heater, %."""
    algorithm = loop.algorithm
    return algorithm.output.maximum_percent if isinstance(algorithm, Pid) else 100.0


def no_rise(site: Site, still: Condition = at_once) -> Trip | None:
    """Heat is asked for, and the reading stands still: 10 or 9, whichever is sooner.

    Rule 10 begins with full power; rule 9 with the step after the last change of the reading, which
    may be one period later than `still` tells.
    """
    loop, moving = site.loop, no_rise_but_moving(site)
    if loop.protection.frozen is None:
        return moving
    allowed_s = lasting_s(loop.protection.frozen.for_s, loop) + loop.period_s
    if moving and moving.allowed_s <= allowed_s:
        heating = loop.protection.heating
        equal = heating is not None and loop.protection.frozen.for_s == heating.within_s
        # Rule 9 does not wait for full power, and so may be sooner by the time it takes.
        return replace(moving, rules=(*moving.rules, "sensor_frozen")) if equal else moving
    return Trip(("sensor_frozen",), allowed_s, still, LONGEST_S)


def no_rise_but_moving(site: Site) -> Trip | None:
    """Full power is asked for, and the reading moves but does not rise: 10 alone can tell.

    It may happen to stand still all the same, long enough for a shorter rule 9.
    """
    loop = site.loop
    heating, frozen = loop.protection.heating, loop.protection.frozen
    if heating is None:
        return None
    shorter = frozen is not None and frozen.for_s < heating.within_s
    rules = ("heating_failed", "sensor_frozen") if shorter else ("heating_failed",)
    due = at_full_power(full_percent(loop))
    return Trip(rules, lasting_s(heating.within_s, loop), due, LONGEST_S)


def too_hot(site: Site) -> Trip:
    """The reading reaches the maximum."""
    loop = site.loop
    due = reaches(loop.protection.maximum_c)
    # Near the end of an analog range one step of the ADC can be more than `rise_rate` allows.
    allowed_k = loop.protection.rise_rate_k_per_s * loop.period_s
    coarse = blur_k(site, loop.protection.maximum_c) > allowed_k
    rules = ("over_temperature", "rise_rate") if coarse else ("over_temperature",)
    return Trip(rules, reading_s(loop), due, LONGEST_S)


def rising(site: Site, *, settle_s: float = 0.0) -> Trip | None:
    """The reading rises although the heater is off, and has been for `settle`."""
    rule = site.loop.protection.rising_while_off
    if rule is None:
        return None
    due = Risen(rule.rise_k, settle_s)
    return Trip(("rising_while_off",), reading_s(site.loop), due, LONGEST_S)


def runaway_above(site: Site, setpoint_c: float) -> Trip | None:
    """The reading leaves the band upwards, and stays outside.

    Within a wide band the heater that is off may be seen to heat before: rule 13.
    """
    rule, rising_rule = site.loop.protection.runaway, site.loop.protection.rising_while_off
    if rule is None:
        return None
    wide = rising_rule is not None and rising_rule.rise_k < rule.above_k
    rules = ("runaway_above", "rising_while_off") if wide else ("runaway_above",)
    allowed_s = lasting_s(rule.for_s, site.loop)
    return Trip(rules, allowed_s, exceeds(setpoint_c + rule.above_k), LONGEST_S)
