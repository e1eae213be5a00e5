"""Heaters, their switches and their fans, and heat from elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from heatwright.sim.faults import currents, effects, starts, trips
from heatwright.sim.faults.bounds import TICK_S, lasting_s
from heatwright.sim.faults.conditions import falls_below
from heatwright.sim.faults.effects import Heat
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.machine import rise_k, share_for, steady_c
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.pins import Level
from heatwright.spec import DigitalOutput

MARGIN_K = 5.0
"""How far beyond a limit the heat of a fault would take the machine."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to the loop."""
    yield from _powerless(site)
    yield from _shorted(site)
    yield from _leaking(site)
    yield from _heat_from_elsewhere(site)
    yield from _heat_lost(site)
    yield from _fan_stopped(site)


def _wire(site: Site, heat: Callable[[World], Heat]) -> Act:
    """Put something between the pin and the heater."""

    def cause(world: World) -> None:
        world.wiring.heat[site.loop.heater] = heat(world)

    return cause


def _mend(site: Site) -> Act:
    def cure(world: World) -> None:
        world.wiring.heat.pop(site.loop.heater)

    return cure


def _powerless(site: Site) -> Iterator[Fault]:
    """A heater that gives nothing, and one that gives a quarter of the least rise."""
    trip, rule = trips.no_rise_but_moving(site), site.loop.protection.heating
    if trip is None or rule is None:
        return

    def demanded(heat: Callable[[World], Heat]) -> Act:
        def cause(world: World) -> None:
            _wire(site, heat)(world)
            world.set_setpoint(starts.highest_c(site))

        return cause

    yield Fault(
        "heater_open",
        lambda: starts.cold(site),
        demanded(lambda _: effects.opened),
        _mend(site),
        trip=currents.no_current(site) or trip,
        again=currents.no_current(site) or trip,
    )
    share = rule.rise_k / rise_k(site, rule.within_s) / 4
    yield Fault(
        "heater_weak",
        lambda: starts.cold(site),
        demanded(lambda _: effects.weakened(share)),
        _mend(site),
        trip=currents.no_current(site, share) or trip,
        again=currents.no_current(site, share) or trip,
    )


def _shorted(site: Site) -> Iterator[Fault]:
    """A switch that conducts for good: where the machine already is tells which rule sees it."""
    short = _wire(site, lambda _: effects.shorted)
    ambient_c = starts.ambient_c(site)
    full_c = steady_c(site, 1.0, ambient_c=ambient_c)
    if full_c >= site.loop.protection.maximum_c + MARGIN_K:
        yield Fault(
            "switch_shorted_when_hot",
            lambda: starts.hot(site),
            short,
            _mend(site),
            trip=currents.current_while_off(site, 1.0, "over_temperature") or trips.too_hot(site),
            again=currents.current_while_off(site, 1.0, "over_temperature") or trips.too_hot(site),
        )
    lowest_c = starts.setpoints_c(site)[0]
    band = trips.runaway_above(site, lowest_c)
    if band and full_c >= lowest_c + _above_k(site) + MARGIN_K:
        yield Fault(
            "switch_shorted_in_band",
            lambda: starts.at_rest(site, above_k=0.0),
            short,
            _mend(site),
            trip=currents.current_while_off(site) or band,
            again=currents.current_while_off(site) or _later(site),
        )


def _later(site: Site) -> Trip | None:
    """Acknowledged outside the band: the band is not armed, so 13 has to see it, or 6.

    A cooler that holds what the switch lets through keeps both from it.
    """
    if site.loop.cooler is not None:
        cooled_c = steady_c(site, 1.0, ambient_c=starts.ambient_c(site), cooled=True)
        if cooled_c < site.loop.protection.maximum_c:
            return None
    rising = trips.rising(site, settle_s=_settle_s(site))
    hot = trips.too_hot(site)
    if rising is None:
        return hot
    return Trip(
        (*rising.rules, *hot.rules),
        rising.allowed_s,
        lambda world: rising.due(world) or hot.due(world),
        trips.LONGEST_S,
    )


def _settle_s(site: Site) -> float:
    rule = site.loop.protection.rising_while_off
    return lasting_s(rule.settle_s, site.loop) if rule else 0.0


def _above_k(site: Site) -> float:
    rule = site.loop.protection.runaway
    return rule.above_k if rule else 0.0


def _leaking(site: Site) -> Iterator[Fault]:
    """A switch that leaks while off, above the band, where only 13 looks."""
    rule, trip = site.loop.protection.rising_while_off, trips.rising(site)
    if rule is None or trip is None:
        return
    above_k = _above_k(site) + MARGIN_K
    start_c = starts.setpoints_c(site)[0] + above_k
    if start_c + rule.rise_k + MARGIN_K >= site.loop.protection.maximum_c:
        return
    share = share_for(site, start_c + 3 * rule.rise_k + MARGIN_K, ambient_c=start_c, cooled=True)

    def settled() -> World:
        world = starts.at_rest(site, above_k=above_k)
        world.run(_settle_s(site))
        return world

    yield Fault(
        "switch_leaking",
        settled,
        _wire(site, lambda _: effects.leaking(share)),
        _mend(site),
        trip=currents.current_while_off(site, share) or trip,
        again=currents.current_while_off(site, share) or _later(site),
    )


def _heat_from_elsewhere(site: Site) -> Iterator[Fault]:
    """Another source that holds the machine above the band, or drives it to its maximum."""
    lowest_c = starts.setpoints_c(site)[0]
    maximum_c = site.loop.protection.maximum_c
    band = trips.runaway_above(site, lowest_c)
    hold_c = lowest_c + _above_k(site) + MARGIN_K

    def held(to_c: float, ambient_c: float, *, cooled: bool = False) -> Act:
        share = 2 * share_for(site, to_c, ambient_c=ambient_c, cooled=cooled)

        def cause(world: World) -> None:
            world.wiring.besides[site.loop.heater] = effects.held_hot(world, to_c, share)

        return cause

    def put_out(world: World) -> None:
        world.wiring.besides.pop(site.loop.heater)

    if band and hold_c + MARGIN_K < maximum_c:
        yield Fault(
            "heat_from_elsewhere",
            lambda: starts.at_rest(site, above_k=0.0),
            held(hold_c, lowest_c, cooled=True),
            put_out,
            trip=band,
        )
    hot = trips.too_hot(site)
    yield Fault(
        "fire",
        lambda: starts.hot(site),
        held(maximum_c + MARGIN_K, starts.ambient_c(site), cooled=_cools_at_once(site)),
        put_out,
        trip=hot,
        again=hot,
    )


def _cools_at_once(site: Site) -> bool:
    """Whether a loop that finds itself far too hot after a reset cools, for it is on by itself."""
    return site.loop.cooler is not None and site.loop.starts != "disabled"


def _heat_lost(site: Site) -> Iterator[Fault]:
    """A heater that goes out while the setpoint is held, where the band has a lower end."""
    runaway = site.loop.protection.runaway
    if runaway is None or runaway.below_k is None:
        return
    target_c = starts.highest_c(site)
    rules = ("runaway_below",) + (("heating_failed",) if site.loop.protection.heating else ())
    yield Fault(
        "heat_lost",
        lambda: starts.held(site),
        _wire(site, lambda _: effects.opened),
        _mend(site),
        trip=currents.no_current(site)
        or Trip(
            rules,
            lasting_s(runaway.for_s, site.loop),
            falls_below(target_c - runaway.below_k),
            trips.LONGEST_S,
        ),
        again=currents.no_current(site) or trips.no_rise_but_moving(site),
    )


def _fan_stopped(site: Site) -> Iterator[Fault]:
    """A fan whose line is forced off, which the controller reads back from its pin."""
    fan = site.loop.fan
    moving = trips.no_rise_but_moving(site)
    if fan is None or moving is None:
        return
    output = site.controller.outputs[fan]
    assert isinstance(output, DigitalOutput)  # noqa: S101 - the language allows no other fan
    off: Level = "low" if output.active == "high" else "high"
    pin = site.controller.board.pins[output.pin].port_name

    def force(level: Level | None) -> Act:
        return lambda world: world.device.avr.pins.drive(pin, level)

    def coasted(world: World) -> bool:
        """The heat already under way no longer raises the temperature."""
        return moving.due(world) and not world.rising

    yield Fault(
        "fan_stopped",
        lambda: starts.heating(site),
        force(off),
        force(None),
        trip=currents.no_current(site)
        or Trip(moving.rules, moving.allowed_s, coasted, trips.LONGEST_S),
        off_within_s=2 * TICK_S,
        again=currents.no_current(site) or moving,
    )
