"""Faults that any kind of sensor can have: wrong temperatures of its tip."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.effects import Felt
from heatwright.sim.faults.fault import Fault, harmless, watched
from heatwright.sim.faults.machine import jump_k, room_k
from heatwright.sim.faults.world import Site

BEYOND_K = 3.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the tip of the loop's sensor."""
    yield from _frost(site)
    yield from _jumps(site)
    yield from _fallen_out(site)


def _frost(site: Site) -> Iterator[Fault]:
    """Yield a tip that is cooled below the minimum, slowly enough not to count as a jump."""
    minimum_c = site.loop.protection.minimum_c
    rate = -site.loop.protection.rise_rate_k_per_s / 2
    start_c = min(starts.resting_c(site), minimum_c + 2 * BEYOND_K)
    cools = Felt(
        site.loop.sensor, lambda world: effects.drifting(world, rate, minimum_c - BEYOND_K)
    )
    yield replace(
        watched(site, "frost", cools, cools.mend),
        make=lambda: starts.resting(site, max(start_c, site.ambient_c)),
    )


def _jumps(site: Site) -> Iterator[Fault]:
    """Yield a loose contact that makes the reading jump, and jumps that are just allowed."""
    loop = site.loop
    limit_k = loop.rise_per_period_k

    def jumps(by_k: float) -> Felt:
        by_turns = partial(effects.jumping, by_k=by_k, every_s=loop.periods_s(4))
        return Felt(loop.sensor, by_turns)

    for name, cause in (("jump_up", jumps(2 * limit_k)), ("jump_down", jumps(-2 * limit_k))):
        yield watched(site, name, cause, cause.mend)
    hold_c = starts.highest_c(site)
    small_k = min(limit_k / 2, room_k(site), jump_k(site, hold_c - starts.BELOW_K, hold_c))
    if small_k > 0:
        yield harmless(site, "small_jumps", jumps(small_k), loop.periods_s(60))


def _fallen_out(site: Site) -> Iterator[Fault]:
    """Yield a sensor that has fallen out of the machine, and cools to the ambient temperature."""
    lag_s = site.network.sense[site.loop.sensor].lag_s

    def falls(name: str) -> Fault:
        cause = Felt(site.loop.sensor, lambda world: effects.fallen_out(world, lag_s))
        return watched(site, name, cause, cause.mend)

    yield falls("fallen_out")
    if site.controller.lockout is not None:
        yield replace(falls("fallen_out_insisted"), again=False, insisted=True)
