"""Machines that are well, of all kinds: nothing may trip."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from heatwright.sim.faults import starts
from heatwright.sim.faults.bears import WARM_DAY_C, room_c
from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.machine import (
    WARM_K,
    blur_k,
    full_percent,
    room_k,
    sensor_step_k,
    usable_c,
)
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.spec import ThermalNetwork

SPREAD = 0.3
"""Capacities and resistances are known to ±30 % when a machine is designed."""
AMBIENTS_C = (10.0, WARM_DAY_C)
"""A workshop in winter and in summer; not beyond where a loop is at fault at rest."""
HOLD_S = 200.0
"""Longer than the rules' times but for `frozen`, which begins anew at every switching."""
LONGEST_S = 3600.0
SIGMAS = 6.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield machines at the corners of the spread, each taken through its range of setpoints."""
    rooms_c = dict.fromkeys(room_c(site.controller, each) for each in AMBIENTS_C)
    for capacity, resistance, ambient_c in itertools.product(
        (1 - SPREAD, 1 + SPREAD), (1 - SPREAD, 1 + SPREAD), rooms_c
    ):
        network = scaled(site.network, capacity, resistance)
        name = f"healthy_{capacity:g}C_{resistance:g}R_{ambient_c:.3g}degC"
        yield from healthy(site, name, network, ambient_c)
    yield from healthy(site, "healthy_noisy", noisy(site), starts.ambient_c(site))


def scaled(network: ThermalNetwork, capacity: float, resistance: float) -> ThermalNetwork:
    """Return a machine whose capacities and resistances are these times as large."""
    nodes = {name: capacity * value for name, value in network.nodes.items()}
    links = tuple(
        link.model_copy(update={"resistance_k_per_w": resistance * link.resistance_k_per_w})
        for link in network.links
    )
    return network.model_copy(update={"nodes": nodes, "links": links})


def noisy(site: Site) -> ThermalNetwork:
    """Return a machine with the most noise that `rise_rate` lets pass: six sigma of a difference.

    The difference of two readings has √2 times the noise of one, and can be a step more: where
    steps are wide, little may be left. Nor may its peaks be a rise while the heater is off, or
    take half of the way to another limit.
    """
    loop = site.loop
    step_k = max(sensor_step_k(site), *(blur_k(site, each) for each in starts.setpoints_c(site)))
    passes_k = loop.protection.rise_rate_k_per_s * loop.period_s - step_k
    allowed_k = max(0.0, passes_k) / 2**0.5
    noise_k = min(allowed_k, room_k(site)) / SIGMAS
    sense = dict(site.network.sense)
    sense[loop.sensor] = sense[loop.sensor].model_copy(update={"noise_k": noise_k})
    return site.network.model_copy(update={"sense": sense})


def healthy(site: Site, name: str, network: ThermalNetwork, ambient_c: float) -> Iterator[Fault]:
    """Take a machine up to the highest setpoint it can hold, down to the lowest, and up again.

    A machine that can hold none is too weak for its controller, and left out.
    """
    most_c = usable_c(site, network, ambient_c=ambient_c)
    setpoints_c = [each for each in starts.setpoints_c(site) if each <= most_c]
    if not setpoints_c:
        return
    target_c = max(setpoints_c)

    def make() -> World:
        start_c = max(ambient_c, target_c - WARM_K)
        world = World(site, Weather(start_c, ambient_c, network))
        starts.first_steps(world)
        return world

    def cause(world: World) -> None:
        for setpoint_c in (target_c, setpoints_c[0], target_c):
            world.set_setpoint(setpoint_c)
            starts.first_steps(world)
            world.until(_has_enough, LONGEST_S)
            world.run(HOLD_S)

    yield Fault(name, make, cause, calm=True)


def _has_enough(world: World) -> bool:
    """Whether the controller no longer asks for full power."""
    return world.loop("duty_percent") < full_percent(world.site.loop)
