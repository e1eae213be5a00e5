"""Faults that any kind of sensor can have: wrong temperatures of its tip."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.fault import Act, Fault
from heatwright.sim.faults.machine import room_k, watch_s
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel
from heatwright.spec.commands import lockout_of

BEYOND_K = 3.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the tip of the loop's sensor."""
    yield from _frost(site)
    yield from _jumps(site)
    yield from _fallen_out(site)


def feel(site: Site, change: Callable[[World], Feel]) -> Act:
    """Return a cause that changes the tip's temperature."""

    def cause(world: World) -> None:
        world.wiring.feel[site.loop.sensor] = change(world)

    return cause


def mend(site: Site) -> Act:
    """Return the cure of `feel`."""

    def cure(world: World) -> None:
        world.wiring.feel.pop(site.loop.sensor)

    return cure


def _frost(site: Site) -> Iterator[Fault]:
    """Yield a tip that is cooled below the minimum, slowly enough not to count as a jump."""
    minimum_c = site.loop.protection.minimum_c
    rate = -site.loop.protection.rise_rate_k_per_s / 2
    start_c = min(starts.resting_c(site), minimum_c + 2 * BEYOND_K)
    yield Fault(
        "frost",
        lambda: starts.resting(site, max(start_c, starts.ambient_c(site))),
        feel(site, lambda world: effects.drifting(world, rate, minimum_c - BEYOND_K)),
        mend(site),
        watch_s=watch_s(site),
        again=True,
    )


def _jumps(site: Site) -> Iterator[Fault]:
    """Yield a loose contact that makes the reading jump, and jumps that are just allowed."""
    loop = site.loop
    limit_k, every_s = loop.rise_per_period_k, loop.periods_s(4)
    for name, by_k in (("jump_up", 2 * limit_k), ("jump_down", -2 * limit_k)):
        yield Fault(
            name,
            lambda: starts.heating(site),
            feel(site, partial(effects.jumping, by_k=by_k, every_s=every_s)),
            mend(site),
            watch_s=watch_s(site),
            again=True,
        )
    yield Fault(
        "small_jumps",
        lambda: starts.heating(site),
        feel(site, partial(effects.jumping, by_k=min(limit_k / 2, room_k(site)), every_s=every_s)),
        calm=True,
        watch_s=loop.periods_s(60),
    )


def _fallen_out(site: Site) -> Iterator[Fault]:
    """Yield a sensor that has fallen out of the machine, and cools to the ambient temperature."""
    lag_s = site.network.sense[site.loop.sensor].lag_s
    yield Fault(
        "fallen_out",
        lambda: starts.heating(site),
        feel(site, lambda world: effects.fallen_out(world, lag_s)),
        mend(site),
        watch_s=watch_s(site),
        again=True,
    )
    if lockout_of(site.controller) is not None:
        yield Fault(
            "fallen_out_insisted",
            lambda: starts.heating(site),
            feel(site, lambda world: effects.fallen_out(world, lag_s)),
            mend(site),
            watch_s=watch_s(site),
            insisted=True,
        )
