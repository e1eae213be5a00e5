"""What the tip of a sensor may come to feel: faults that any kind of sensor can have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from heatwright.sim.faults import effects, starts, trips
from heatwright.sim.faults.bounds import lasting_s, reading_s
from heatwright.sim.faults.conditions import falls_below, falls_to
from heatwright.sim.faults.effects import Feel
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.world import Site, World

BEYOND_K = 3.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to the loop's sensor."""
    yield from _frost(site)
    yield from _jumps(site)
    yield from _fallen_out(site)


def feel(site: Site, change: Callable[[World], Feel]) -> Act:
    """Put something between the machine and the tip."""

    def cause(world: World) -> None:
        world.wiring.feel[site.loop.sensor] = change(world)

    return cause


def mend(site: Site) -> Act:
    """Take it away."""

    def cure(world: World) -> None:
        world.wiring.feel.pop(site.loop.sensor)

    return cure


def _frost(site: Site) -> Iterator[Fault]:
    """A tip that is cooled below the minimum, slowly enough not to jump."""
    minimum_c = site.loop.protection.minimum_c
    rate = -site.loop.protection.rise_rate_k_per_s / 2
    start_k = starts.resting_c(site) - minimum_c - BEYOND_K
    trip = Trip(("under_temperature",), reading_s(site.loop), falls_to(minimum_c), trips.LONGEST_S)
    yield Fault(
        "frost",
        lambda: starts.cold(site, below_k=start_k),
        feel(site, lambda world: effects.drifting(world, rate, minimum_c - BEYOND_K)),
        mend(site),
        trip=trip,
        again=Trip(trip.rules, trip.allowed_s),
    )


def _jumps(site: Site) -> Iterator[Fault]:
    """A loose contact that makes the reading jump; and jumps that are just allowed."""
    loop = site.loop
    limit_k = loop.protection.rise_rate_k_per_s * loop.period_s
    every_s = 4 * loop.period_s
    for name, by_k in (("jump_up", 2 * limit_k), ("jump_down", -2 * limit_k)):
        yield Fault(
            name,
            lambda: starts.heating(site),
            feel(site, partial(effects.jumping, by_k=by_k, every_s=every_s)),
            mend(site),
            trip=Trip(("rise_rate",), reading_s(loop)),
            again=Trip(("rise_rate",), every_s + reading_s(loop)),
        )
    yield Fault(
        "small_jumps",
        lambda: starts.heating(site),
        feel(site, partial(effects.jumping, by_k=limit_k / 2, every_s=every_s)),
        watch_s=60 * loop.period_s,
    )


def _fallen_out(site: Site) -> Iterator[Fault]:
    """A sensor that has fallen out of the machine, and cools to the surroundings."""
    trip, again = _after_falling(site), trips.no_rise(site, falls_to(starts.ambient_c(site)))
    if trip is None:
        return
    if again is not None and _may_jump(site):
        again = replace(again, rules=("rise_rate", *again.rules))  # it still falls
    lag_s = site.network.sense[site.loop.sensor].lag_s
    yield Fault(
        "fallen_out",
        lambda: starts.heating(site),
        feel(site, lambda world: effects.fallen_out(world, lag_s)),
        mend(site),
        trip=trip,
        again=again,
    )


def _after_falling(site: Site) -> Trip | None:
    """Whatever sees it first: the fall itself, the lower end of the band, or that nothing rises."""
    loop = site.loop
    runaway = loop.protection.runaway
    trip = trips.no_rise(site, falls_to(starts.ambient_c(site)))
    if runaway is not None and runaway.below_k is not None:
        below = falls_below(starts.highest_c(site) - runaway.below_k)
        rules = ("runaway_below", *(trip.rules if trip else ()))
        trip = Trip(rules, lasting_s(runaway.for_s, loop), below, trips.LONGEST_S)
    if trip is None or not _may_jump(site):
        return trip
    return replace(trip, rules=("rise_rate", *trip.rules))


def _may_jump(site: Site) -> bool:
    """Whether the first reading may differ enough; its exact value depends on the moment."""
    loop = site.loop
    lag_s = site.network.sense[loop.sensor].lag_s
    drop_k = starts.highest_c(site) - starts.ambient_c(site)
    first_k = drop_k * (1 - math.exp(-loop.period_s / lag_s)) if lag_s else drop_k
    return first_k > loop.protection.rise_rate_k_per_s * loop.period_s / 2
