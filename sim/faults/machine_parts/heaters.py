"""Faults of heaters, their switches and their fans, and heat from other sources."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bounds import TICK_S, lasting_s
from heatwright.sim.faults.effects import Heated
from heatwright.sim.faults.fault import Fault, watched
from heatwright.sim.faults.machine import rise_k, share_for, watch_s
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Beside, Heat
from heatwright.sim.native.pins import Level

MARGIN_K = 5.0
"""How far beyond a limit the heat of a fault takes the machine."""
WEAK_SHARE = 0.05
"""Share of its power that a heater still has when its wire is almost broken."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's heater, its switch and its fan."""
    yield _switch(site, "heater_open", lambda: _wanted(site), effects.OPENED)
    yield _switch(site, "heater_weak", lambda: _wanted(site), effects.weakened(_weak_share(site)))
    yield _switch(site, "heat_lost", lambda: starts.held(site), effects.OPENED)
    yield _switch(site, "switch_shorted_when_hot", lambda: starts.hot(site), effects.SHORTED)
    yield _switch(
        site, "switch_shorted_in_band", lambda: starts.at_rest(site, above_k=0.0), effects.SHORTED
    )
    yield _leaking(site)
    yield from _heat_from_elsewhere(site)
    yield from _fan_stopped(site)


def _switch(site: Site, name: str, make: Callable[[], World], heat: Heat) -> Fault:
    cause = Heated(site.loop.heater, heat)
    return replace(watched(site, name, cause, cause.mend), make=make)


def _wanted(site: Site) -> World:
    """Return a cold world with the highest setpoint that the machine can hold."""
    world = starts.cold(site)
    world.set_setpoint(starts.highest_c(site))
    return world


def _weak_share(site: Site) -> float:
    """Return the share of full power for a quarter of the rise that `heating_failed` demands."""
    rule = site.loop.protection.heating
    return rule.rise_k / rise_k(site, rule.within_s) / 4 if rule else WEAK_SHARE


def _leaking(site: Site) -> Fault:
    """Return a switch that leaks while it is off, above the band: enough to heat the machine more.

    If the band ends near the maximum, the machine starts halfway to the maximum.
    """
    runaway, rising = site.loop.protection.runaway, site.loop.protection.rising_while_off
    lowest_c = starts.setpoints_c(site)[0]
    above_k = min(
        (runaway.above_k if runaway else 0.0) + MARGIN_K,
        (site.loop.protection.maximum_c - lowest_c) / 2,
    )
    start_c = lowest_c + above_k
    level_c = start_c + 3 * (rising.rise_k if rising else MARGIN_K) + MARGIN_K
    share = share_for(site, level_c, ambient_c=site.ambient_c, cooled=True)

    def settled() -> World:
        world = starts.at_rest(site, above_k=above_k)
        world.run(lasting_s(rising.settle_s, site.loop) if rising else 0.0)
        return world

    return _switch(site, "switch_leaking", settled, effects.leaking(min(1.0, share)))


def _heat_from_elsewhere(site: Site) -> Iterator[Fault]:
    """Yield another source of heat that holds the machine above the band or above its maximum."""
    runaway, maximum_c = site.loop.protection.runaway, site.loop.protection.maximum_c
    above_c = starts.setpoints_c(site)[0] + (runaway.above_k if runaway else 0.0) + MARGIN_K
    for name, make, hold_c in (
        ("heat_from_elsewhere", lambda: starts.at_rest(site, above_k=0.0), above_c),
        ("fire", lambda: starts.hot(site), maximum_c + MARGIN_K),
    ):
        share = 2 * share_for(site, hold_c, ambient_c=site.ambient_c, cooled=True)

        def cause(world: World, hold_c: float = hold_c, share: float = share) -> None:
            world.wiring.besides[site.loop.heater] = Beside(share, site.loop.sensor, hold_c)

        def cure(world: World) -> None:
            world.wiring.besides.pop(site.loop.heater)

        yield Fault(name, make, cause, cure, watch_s=watch_s(site), again=True)


def _fan_stopped(site: Site) -> Iterator[Fault]:
    """Yield a fan whose line is forced off, which the controller reads back from its pin."""
    fan = site.loop.fan
    if fan is None:
        return
    output = site.controller.on_off_output(fan)
    off: Level = "low" if output.active == "high" else "high"
    pin = site.controller.board.pins[output.pin].port_name
    stopped = watched(
        site,
        "fan_stopped",
        lambda world: world.device.avr.pins.drive(pin, off),
        lambda world: world.device.avr.pins.drive(pin, None),
    )
    yield replace(stopped, off_within_s=2 * TICK_S)
