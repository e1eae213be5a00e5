"""Faults after which there is no valid reading, for any kind of sensor."""

from collections.abc import Callable
from dataclasses import replace

from heatwright.sim.faults.bounds import answer_s, reading_s
from heatwright.sim.faults.effects import Felt
from heatwright.sim.faults.fault import Act, Fault, Trip, harmless, tripping, watched
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel
from heatwright.sim.sensors.ds18b20 import Ds18b20
from heatwright.sim.sensors.spi_chip import SpiChip
from heatwright.spec import RULES

SENSOR_RULES = tuple(RULES[code].id for code in (1, 2, 3, 4, 5, 17, 18))
"""Ids of all rules that trip without a valid reading."""


def no_reading(site: Site, name: str, cause: Act, cure: Act) -> Fault:
    """Return a fault without a valid reading: the heater goes off at the first invalid one."""
    trips = tripping(site, name, cause, Trip(SENSOR_RULES, answer_s(site.loop)), cure)
    return replace(trips, off_within_s=reading_s(site.loop), sensor_lies=True, again=True)


def slow_conversions(site: Site, act: Act, watch_s: float) -> Fault:
    """Return the fault of a chip that is slower than its data sheet: no rule may trip."""
    return replace(harmless(site, "slow_conversions", act, watch_s), sensor_lies=True)


LACKS_HEAT = ("heating_failed", "runaway_below")
"""Rules that may trip while there are no readings, because then there is no heat."""

CURRENT_RULES = tuple(RULES[code].id for code in (20, 21, 22))
"""Rules that may trip when a current is no longer measured."""


def bursts(site: Site, name: str, act: Act, cure: Act, watch_s: float) -> Fault:
    """Return a fault whose readings fail in bursts: no rule of the sensor may trip.

    Each burst switches the heater off until the next reading or window. So rules that watch the
    heating may trip: a cooled machine may not become warm again in time.
    """
    return replace(
        watched(site, name, act, cure), watch_s=watch_s, again=False, judge=_sensor_is_believed
    )


def bursts_of_damage(
    site: Site, chip_of: Callable[[World], Ds18b20 | SpiChip], most: int, periods: int, for_s: float
) -> Fault:
    """Return the fault of a chip that damages some answers in a row, again and again.

    periods -- from one burst to the next; for_s -- how long it is watched, s.
    """
    every_s = site.loop.periods_s(periods)

    def at_times(world: World) -> Feel:
        turn = int(world.now_s / every_s)

        def feel(felt_c: float) -> float:
            nonlocal turn
            now = int(world.now_s / every_s)
            if now != turn:
                chip_of(world).faults.corrupt_next = most
            turn = now
            return felt_c

        return feel

    def cure(world: World) -> None:
        damage.mend(world)
        chip_of(world).faults.corrupt_next = 0

    damage = Felt(site.loop.sensor, at_times)
    return bursts(site, "answers_damaged_in_bursts", damage, cure, for_s)


def _sensor_is_believed(world: World) -> str:
    """Check that no rule tripped except those that watch the heating."""
    found = {RULES[trip.code].id for trip in world.trips.since(0.0)} - set(LACKS_HEAT)
    return f"{' and '.join(sorted(found))} tripped for no reason" if found else ""
