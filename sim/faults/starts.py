"""States in which faults meet a machine, reached soon: it begins near where it has to be."""

from __future__ import annotations

from heatwright.sim.faults.machine import sensor_step_k, usable_c
from heatwright.sim.faults.world import Site, Weather, World

BELOW_K = 5.0
"""So far below its setpoint a machine begins that is to be heating."""
FIRST_STEPS = 3
"""Periods after which readings come, every rule has begun and the setpoint is taken over."""
LONGEST_S = 3600.0


def ambient_c(site: Site) -> float:
    """Return the temperature of the surroundings as specified, °C."""
    simulation = site.controller.simulation
    return simulation.ambient_c if simulation else 20.0


def key_setpoints_c(site: Site) -> tuple[float, ...]:
    """Return the setpoints the keys can reach, ascending; without keys the initial one alone."""
    setpoint, step_k = site.loop.setpoint, site.key_step_k
    if not step_k:
        return (setpoint.initial_c,)
    down = int((setpoint.initial_c - setpoint.minimum_c) / step_k)
    up = int((setpoint.maximum_c - setpoint.initial_c) / step_k)
    return tuple(setpoint.initial_c + turn * step_k for turn in range(-down, up + 1))


def highest_c(site: Site) -> float:
    """Return the highest setpoint the keys reach and the machine can hold, °C."""
    most_c = usable_c(site, site.network, ambient_c=ambient_c(site))
    reached = [each for each in key_setpoints_c(site) if each <= most_c]
    return max(reached, default=min(key_setpoints_c(site)))


def first_steps(world: World) -> None:
    """Let the controller start."""
    world.run(FIRST_STEPS * world.site.loop.period_s)


def heating(site: Site) -> World:
    """Begin below the highest usable setpoint, with the heater on at this moment."""
    target_c = highest_c(site)
    world = World(site, Weather(target_c - BELOW_K, ambient_c(site)))
    first_steps(world)
    world.set_setpoint(target_c)
    world.until(heater_is_on, LONGEST_S)
    return world


def heater_is_on(world: World) -> bool:
    """Whether the loop's heater is on at this moment, by its controller."""
    return world.device.outputs[world.site.loop.heater].on


def at_rest(site: Site, *, above_k: float) -> World:
    """Begin with a machine that rests so far above the lowest setpoint, heater off."""
    start_c = key_setpoints_c(site)[0] + above_k
    world = World(site, Weather(start_c, start_c))
    first_steps(world)
    world.set_setpoint(start_c - above_k)
    first_steps(world)
    return world


def cold(site: Site, *, below_k: float = 2 * BELOW_K) -> World:
    """Begin with a machine that rests so far below the initial setpoint."""
    start_c = site.loop.setpoint.initial_c - below_k
    world = World(site, Weather(start_c, start_c))
    first_steps(world)
    return world


def hot(site: Site) -> World:
    """Begin just below the protection's maximum."""
    start_c = site.loop.protection.maximum_c - 1.0 - sensor_step_k(site)
    world = World(site, Weather(start_c, ambient_c(site)))
    first_steps(world)
    return world


def held(site: Site) -> World:
    """Begin at the highest usable setpoint, and hold it until the heater goes off and on."""
    target_c = highest_c(site)
    world = World(site, Weather(target_c, ambient_c(site)))
    first_steps(world)
    world.set_setpoint(target_c)
    world.until(heater_is_on, LONGEST_S)
    world.until(lambda now: not heater_is_on(now), LONGEST_S)
    world.until(heater_is_on, LONGEST_S)
    return world
