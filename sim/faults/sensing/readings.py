"""Faults after which there is no valid reading, for any kind of sensor."""

from __future__ import annotations

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s, reading_s
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.world import Site, World
from heatwright.spec.rules import RULES

SENSOR_RULES = tuple(RULES[code].id for code in (1, 2, 3, 4, 5, 17, 18))
"""Ids of all rules that trip without a valid reading."""


def no_reading(site: Site, name: str, cause: Act, cure: Act) -> Fault:
    """Return a fault without a valid reading: the heater goes off at the first invalid one."""
    return Fault(
        name,
        lambda: starts.heating(site),
        cause,
        cure,
        trip=Trip(SENSOR_RULES, answer_s(site.loop)),
        off_within_s=reading_s(site.loop),
        sensor_lies=True,
        again=True,
    )


def slow_conversions(site: Site, act: Act, watch_s: float) -> Fault:
    """Return the fault of a chip that is slower than its data sheet: no rule may trip."""
    return Fault(
        "slow_conversions",
        lambda: starts.heating(site),
        act,
        calm=True,
        sensor_lies=True,
        watch_s=watch_s,
    )


LACKS_HEAT = ("heating_failed", "runaway_below")
"""Rules that may trip without readings: without them there is no heat."""

CURRENT_RULES = tuple(RULES[code].id for code in (20, 21, 22))
"""Rules that may trip when a current is no longer measured."""


DAMAGED_ANSWERS = "answers_damaged_in_bursts"
"""Id of a fault of all sensors that answer with data words."""


def bursts(site: Site, name: str, act: Act, cure: Act, watch_s: float) -> Fault:
    """Return a fault whose readings fail in bursts: no rule of the sensor may trip.

    Each burst switches the heater off until the next reading or window. So rules that watch the
    heating may trip: a cooled machine may not become warm again in time.
    """
    return Fault(
        name,
        lambda: starts.heating(site),
        act,
        cure,
        watch_s=watch_s,
        judge=_sensor_is_believed,
    )


def _sensor_is_believed(world: World) -> str:
    """Check that no rule tripped except those that watch the heating."""
    found = {RULES[trip.code].id for trip in world.trips.since(0.0)} - set(LACKS_HEAT)
    return f"{' and '.join(sorted(found))} tripped for no reason" if found else ""
