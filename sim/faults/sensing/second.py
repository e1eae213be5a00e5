"""Sensors with wrong but plausible readings: only the loop's second sensor reveals them."""

import math
from collections.abc import Iterator
from dataclasses import replace

from heatwright.sim.faults.effects import Change, Felt
from heatwright.sim.faults.fault import Fault, watched
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel

DRIFT_K_PER_S = 0.05
CREEP_S = 1200.0
"""Time constant with which a sensor moves out of its place."""
LATER_S = 120.0
"""How long to watch after the time in which both sensors must differ."""
TIMES = 3.0
"""Factor on the time: the control follows the wrong sensor and so hides part of the difference."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield wrong readings that only a second sensor reveals, if the loop has one."""
    loop, agreement = site.loop, site.loop.protection.agreement
    if loop.also is None or agreement is None:
        return
    second = site.controller.monitors[loop.also].sensor
    rate_k_per_s = min(DRIFT_K_PER_S, loop.protection.rise_rate_k_per_s / 2)
    drifts_s = TIMES * agreement.within_k / rate_k_per_s + agreement.for_s + LATER_S
    creeps_s = TIMES * CREEP_S + agreement.for_s

    def drift(world: World) -> Feel:
        began_s, lowest_c = world.now_s, loop.protection.minimum_c
        return lambda felt_c: max(lowest_c, felt_c - rate_k_per_s * (world.now_s - began_s))

    def creep(world: World) -> Feel:
        began_s, around_c = world.now_s, world.ambient_c
        return lambda felt_c: (
            around_c + (felt_c - around_c) * math.exp(-(world.now_s - began_s) / CREEP_S)
        )

    yield _lies(site, "sensor_drifts_low", loop.sensor, drift, drifts_s)
    yield _lies(site, "second_sensor_drifts_low", second, drift, drifts_s)
    yield _lies(site, "sensor_creeps_out", loop.sensor, creep, creeps_s)


def _lies(site: Site, name: str, sensor: str, change: Change, watch_s: float) -> Fault:
    cause = Felt(sensor, change)
    return replace(
        watched(site, name, cause, cause.mend),
        watch_s=watch_s,
        judge=lambda world: "" if world.trips.changes else "no rule tripped",
    )
