"""Worlds in the states in which faults occur; the machine starts close to the wanted state.

It never starts colder than its ambient, even if its setpoint is lower.
"""

from functools import lru_cache

from heatwright.sim.faults.bears import coldest_c, hottest_c
from heatwright.sim.faults.machine import sensor_step_k, usable_c
from heatwright.sim.faults.site import OfState, Operated, Place
from heatwright.sim.faults.world import Condition, Site, Weather, World, given, switched
from heatwright.sim.plants import profile_c

COMMANDED_STEP_K = 10.0
BELOW_K = 5.0
"""A machine that has to heat starts this far below the temperature at which its heater goes on."""
FIRST_STEPS = 3
"""Periods after which readings come, every rule has begun and the new setpoint is in use."""
LONGEST_S = 3600.0
SINGLE_K = 0.001
"""More than the rounding error of a few key steps, and less than the finest setpoint step."""


def setpoints_c(site: Place) -> tuple[float, ...]:
    """Return setpoints that the operator can set, °C, ascending; without one, the initial one.

    A host can set any: these go down from the maximum in steps of 10 K. A keypad changes the
    initial setpoint by its own steps, or by several steps at once in a menu.
    """
    setpoint, step_k = site.loop.setpoint, site.key_step_k
    if site.has_menu:
        step_k *= max(1, round(COMMANDED_STEP_K / step_k))
    if site.facts.commanded and not site.has_keys_alone:
        lowest_c = max(setpoint.minimum_c, site.ambient_c)
        count = int((setpoint.maximum_c - lowest_c) / COMMANDED_STEP_K)
        return tuple(setpoint.maximum_c - turn * COMMANDED_STEP_K for turn in range(count, -1, -1))
    if not step_k:
        return (setpoint.initial_c,)
    down = int((setpoint.initial_c - setpoint.minimum_c) / step_k)
    up = int((setpoint.maximum_c - setpoint.initial_c) / step_k)
    return tuple(setpoint.initial_c + turn * step_k for turn in range(-down, up + 1))


@lru_cache(maxsize=16)
def highest_c(site: Place) -> float:
    """Return the highest setpoint that the operator can set and the machine can hold, °C."""
    most_c = usable_c(site, site.network, ambient_c=site.ambient_c)
    reached = [each for each in setpoints_c(site) if each <= most_c]
    return max(reached, default=min(setpoints_c(site)))


@lru_cache(maxsize=16)
def permitted_c(site: Place, start_c: float) -> float:
    """Return a start temperature, °C: `start_c`, if no monitor and no other loop trips there.

    Otherwise the highest one below it: the other sensors become warm with the loop.
    """
    limits_c, around_c = hottest_c(site.controller, site.loop_name), site.ambient_c
    if not limits_c:
        return start_c
    nodes_c = profile_c(site.controller, site.network, site.loop_name, start_c, ambient_c=around_c)
    permitted = start_c
    for sensor, most_c in limits_c:
        node_c = nodes_c.get(str(site.network.sense[sensor].node), around_c)
        if node_c > most_c > around_c:
            share = (most_c - around_c) / (node_c - around_c)  # the rises are proportional
            permitted = min(permitted, around_c + share * (start_c - around_c))
    return permitted


def setpoint_moved(world: World, expected_c: float) -> str:
    """Return a complaint if the setpoint is not the expected one in single precision; else ""."""
    found_c = world.setpoint_c
    exact = abs(found_c - expected_c) < SINGLE_K
    return "" if exact else f"the setpoint is {found_c:g} °C, not {expected_c:g}"


def first_steps(world: Operated) -> None:
    """Run the first periods, until the controller has readings and follows its setpoint."""
    world.run(world.site.loop.periods_s(FIRST_STEPS))


def begun(site: Site, start_c: float) -> World:
    """Return a world that starts at a temperature, °C, after its first periods."""
    world = World(site, Weather(start_c, site.ambient_c))
    first_steps(world)
    return world


def heating(site: Site) -> World:
    """Return a world below its highest usable setpoint, at a moment when the heater is on."""
    return _heating_from(site, highest_c(site) - site.loop.algorithm.swing_k / 2 - BELOW_K)


def warming_up(site: Site) -> World:
    """Return a world whose heater has just gone on at the ambient temperature."""
    return _heating_from(site, site.ambient_c)


def _heating_from(site: Site, start_c: float) -> World:
    coldest = coldest_c(site.controller, site.loop_name)
    world = begun(site, max(start_c, coldest, site.ambient_c))
    world.set_setpoint(highest_c(site))
    world.until(heater_on(site), LONGEST_S)
    return world


def heater_on(site: Site) -> Condition:
    """Return the condition that the controller has the loop's heater on.

    A heater under PWM counts as on while its duty is not 0: samples of its pin at regular
    intervals could always hit the same part of its period.
    """
    if site.controller.outputs[site.loop.heater].frequency_hz:
        return given(site)
    return switched(on=True)


def at_rest(site: Site, *, above_k: float) -> World:
    """Return a world `above_k` above its setpoint, which is the lowest one: the heater is off."""
    lowest_c = setpoints_c(site)[0]
    world = resting(site, max(lowest_c, site.ambient_c) + above_k)
    world.set_setpoint(lowest_c)
    first_steps(world)
    return world


def cold(site: Site) -> World:
    """Return a world whose machine is at its ambient temperature."""
    return resting(site, site.ambient_c)


def resting(site: Site, start_c: float) -> World:
    """Return a world that starts at a temperature, °C, or below it if a rule would trip there."""
    return begun(site, permitted_c(site, start_c))


def resting_c(site: Site) -> float:
    """Return the initial setpoint, °C; for a loop that starts off, the ambient temperature."""
    initial_c = site.loop.setpoint.initial_c
    return site.ambient_c if site.facts.commanded and initial_c == 0 else initial_c


def hot(site: Site) -> World:
    """Return a world just below the protection's maximum, or at another loop's or monitor's limit.

    A safety relay is closed: an open one would cut the supply of every heater.
    """
    world = resting(site, site.loop.protection.maximum_c - 1.0 - sensor_step_k(site))
    if site.controller.safety.relay is not None:
        if site.facts.switched:
            world.switch(on=True)
        elif site.facts.hosted:
            world.set_setpoint(setpoints_c(site)[0])
    return world


def held(site: Site) -> World:
    """Return a world at its highest usable setpoint, held until the heater has gone off and on.

    A heater under PWM switches all the time: it is held until the duty is below full.
    """
    target_c = highest_c(site)
    world = begun(site, max(target_c, site.ambient_c))
    world.set_setpoint(target_c)
    world.until(heater_on(site), LONGEST_S)
    if site.controller.outputs[site.loop.heater].frequency_hz:
        full = site.loop.algorithm.full_percent
        world.until(OfState(lambda now: 0 < now.loop("duty_percent") < full), LONGEST_S)
        return world
    world.until(switched(on=False), LONGEST_S)
    world.until(heater_on(site), LONGEST_S)
    return world
