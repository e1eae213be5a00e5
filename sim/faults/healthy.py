"""Healthy machines at the corners of the spec's tolerances: no rule may trip."""

import itertools
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from heatwright.sim.faults import starts
from heatwright.sim.faults.bears import SIGMAS, WARM_DAY_C, room_c
from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.machine import WARM_K, blur_k, room_k, sensor_step_k, usable_c
from heatwright.sim.faults.site import OfState, Operated, Place, Site
from heatwright.sim.faults.world import Weather, World
from heatwright.spec import ThermalNetwork

AMBIENTS_C = (10.0, WARM_DAY_C)
"""A workshop in winter and in summer; limited so that no rule trips in the steady state."""
HOLD_S = 200.0
"""Longer than rules usually take to trip, except `frozen`, which restarts at each switching."""
HOLD_PERIODS = 1000
"""Hold this many periods, or twice the longest time of a rule if longer, but at most HOLD_S."""
LONGEST_S = 3600.0


class Healthy(NamedTuple):
    """A healthy machine, its temperature at the start, and the setpoints of its trial, °C.

    what -- how it differs from the plant, for messages.
    """

    name: str
    what: str
    network: ThermalNetwork
    start_c: float
    ambient_c: float
    setpoints_c: tuple[float, ...]


def faults(site: Site) -> Iterator[Fault]:
    """Yield a fault for each healthy machine: no rule may trip."""
    for each in machines(site):
        yield healthy(site, each)


def machines(site: Place) -> Iterator[Healthy]:
    """Yield machines at the corners of the tolerances, and a noisy one, each with its setpoints.

    Each goes up to the highest setpoint it can hold, down to the lowest, and up again. A machine
    that can hold none is too weak for its controller, and is left out.
    """
    rooms_c = dict.fromkeys(room_c(site.controller, each) for each in AMBIENTS_C)
    spread = site.network.tolerance_percent / 100
    for capacity, resistance, ambient_c in itertools.product(
        (1 - spread, 1 + spread), (1 - spread, 1 + spread), rooms_c
    ):
        network = scaled(site.network, capacity, resistance)
        name = f"healthy_{capacity:g}C_{resistance:g}R_{ambient_c:.3g}degC"
        what = (
            f"{capacity:g} times the heat capacities of the plant, {resistance:g} times its "
            f"resistances, {ambient_c:.3g} °C ambient"
        )
        yield from reachable(site, name, what, network, ambient_c)
    what = "the most noise at its sensor that trips no rule"
    yield from reachable(site, "healthy_noisy", what, noisy(site), site.ambient_c)


def reachable(
    site: Place, name: str, what: str, network: ThermalNetwork, ambient_c: float
) -> Iterator[Healthy]:
    """Yield a machine with the setpoints that it can hold; nothing if there are none."""
    most_c = usable_c(site, network, ambient_c=ambient_c)
    setpoints_c = [each for each in starts.setpoints_c(site) if each <= most_c]
    if setpoints_c:
        target_c = max(setpoints_c)
        start_c = max(ambient_c, target_c - WARM_K)
        yield Healthy(name, what, network, start_c, ambient_c, (target_c, setpoints_c[0], target_c))


def take_through(world: Operated, setpoints_c: Iterable[float]) -> None:
    """Set one setpoint after the other, and hold each for a while.

    A loop with `on_for_at_most` is switched off and on between them, which restarts that time.
    """
    full = world.site.loop.algorithm.full_percent
    most_s = world.site.loop.protection.on_for_at_most_s
    has_enough = OfState(lambda now: now.loop("duty_percent") < full)
    for setpoint_c in setpoints_c:
        if most_s is not None:
            world.switch_off()
            starts.first_steps(world)
        world.set_setpoint(setpoint_c)
        starts.first_steps(world)
        world.until(has_enough, LONGEST_S)
        world.run(_hold_s(world.site))


def scaled(network: ThermalNetwork, capacity: float, resistance: float) -> ThermalNetwork:
    """Return a machine whose heat capacities and resistances are multiplied by these factors."""
    nodes = {name: capacity * value for name, value in network.nodes.items()}
    links = tuple(
        link.model_copy(update={"resistance_k_per_w": resistance * link.resistance_k_per_w})
        for link in network.links
    )
    return network.model_copy(update={"nodes": nodes, "links": links})


def noisy(site: Place) -> ThermalNetwork:
    """Return a machine with the most noise that rule `rise_rate` tolerates: six sigma.

    The difference of two readings has √2 times the noise of one, and can be one step larger:
    wide steps leave little room for noise. Its peaks also stay below the rise that counts while
    the heater is off, and below half of the distance to any other limit.
    """
    loop = site.loop
    setpoints_c = starts.setpoints_c(site)
    blurs_k = (blur_k(site.controller, loop.sensor, each) for each in setpoints_c)
    step_k = max(sensor_step_k(site), *blurs_k)
    allowed_k = max(0.0, loop.rise_per_period_k - step_k) / 2**0.5
    noise_k = min(allowed_k, room_k(site)) / SIGMAS
    sense = dict(site.network.sense)
    sense[loop.sensor] = sense[loop.sensor].model_copy(update={"noise_k": noise_k})
    return site.network.model_copy(update={"sense": sense})


def _hold_s(site: Place) -> float:
    protection = site.loop.protection
    times_s = [
        protection.heating.within_s if protection.heating else 0.0,
        protection.runaway.for_s if protection.runaway else 0.0,
        protection.rising_while_off.settle_s if protection.rising_while_off else 0.0,
    ]
    return min(HOLD_S, max(2 * max(times_s), site.loop.periods_s(HOLD_PERIODS)))


def healthy(site: Site, machine: Healthy) -> Fault:
    """Return the trial of a healthy machine: no rule may trip."""

    def make() -> World:
        world = World(site, Weather(machine.start_c, machine.ambient_c, machine.network))
        starts.first_steps(world)
        return world

    def cause(world: World) -> None:
        take_through(world, machine.setpoints_c)

    return Fault(machine.name, make, cause, calm=True)
