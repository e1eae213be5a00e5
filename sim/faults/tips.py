"""What the tip of a sensor may come to feel: faults that any kind of sensor can have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

from heatwright.sim.faults import effects, starts, trips
from heatwright.sim.faults.bounds import reading_s
from heatwright.sim.faults.conditions import falls_to
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
    start_k = site.loop.setpoint.initial_c - minimum_c - BEYOND_K
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
    moving = trips.no_rise(site)
    if moving is None:
        return
    loop = site.loop
    lag_s = site.network.sense[loop.sensor].lag_s
    drop_k = starts.highest_c(site) - starts.BELOW_K - starts.ambient_c(site)
    first_k = drop_k * (1 - math.exp(-loop.period_s / lag_s)) if lag_s else drop_k
    limit_k = loop.protection.rise_rate_k_per_s * loop.period_s
    rules = moving.rules
    if first_k > limit_k / 2:  # the exact drop depends on the temperature at that moment
        rules = ("rise_rate", *rules)
    yield Fault(
        "fallen_out",
        lambda: starts.heating(site),
        feel(site, lambda world: effects.fallen_out(world, lag_s)),
        mend(site),
        trip=Trip(rules, moving.allowed_s, moving.due, moving.due_within_s),
        again=moving,
    )
