"""Faults that leave no valid reading, whatever the sensor."""

from __future__ import annotations

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s, reading_s
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.world import Site, World
from heatwright.spec.rules import RULES

SENSOR_RULES = tuple(RULES[code].id for code in (1, 2, 3, 4, 5, 17, 18))
"""Those that tell that there is no valid reading, whatever it is."""


def no_reading(site: Site, name: str, cause: Act, cure: Act) -> Fault:
    """Make a fault that leaves no valid reading: the heater is off at the first one that fails."""
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
    """Make a chip slower than its data sheet says, which must not stop a machine."""
    return Fault(
        "slow_conversions",
        lambda: starts.heating(site),
        act,
        calm=True,
        sensor_lies=True,
        watch_s=watch_s,
    )


LACKS_HEAT = ("heating_failed", "runaway_below")
"""What may tell that no readings come: without them there is no heat."""

CURRENT_RULES = tuple(RULES[code].id for code in (20, 21, 22))
"""What may tell of a current that is not measured any more."""


DAMAGED_ANSWERS = "answers_damaged_in_bursts"
"""What all sensors that answer in words can have."""


def bursts(site: Site, name: str, act: Act, cure: Act, watch_s: float) -> Fault:
    """Have readings fail in bursts, which no rule of the sensor may take for its end.

    Each costs heat: until the next reading, or the next window. What comes of that is for the rules
    that judge heat: a machine that cooled for so long may not regain it in time.
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
    """Check that no rule told that there is no reading."""
    found = {RULES[trip.code].id for trip in world.trips.since(0.0)} - set(LACKS_HEAT)
    return f"{' and '.join(sorted(found))} tripped for no reason" if found else ""
