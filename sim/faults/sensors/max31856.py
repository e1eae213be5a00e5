"""Faults of a MAX31856, which is also configured, and tests for an open input only now and then."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s, reading_s
from heatwright.sim.faults.fault import Act, Fault, Trip, tripping
from heatwright.sim.faults.sensing.converter import (
    chip_of,
    conversions,
    failing_supply,
    slow,
    wires,
)
from heatwright.sim.faults.sensing.converter import cut as break_thermocouple
from heatwright.sim.faults.sensing.converter import mend as mend_thermocouple
from heatwright.sim.faults.sensing.readings import no_reading
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.pins import Level
from heatwright.sim.sensors.max31856 import TEST_EVERY, Max31856
from heatwright.sim.sensors.max31856_registers import TEST_S

TOO_HOT_C, USUAL_C = 130.0, 25.0
"""A cold junction beyond the chip's range, and a usual one."""


def cut(world: World) -> None:
    """Short the chip's data output to ground."""
    chip_of(world).short("low")


def mend(world: World) -> None:
    """Remove the short."""
    chip_of(world).short(None)


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's MAX31856."""
    yield from wires(site)
    yield from _broken(site)
    yield failing_supply(site)
    yield no_reading(site, "orders_shorted_to_supply", _orders("high"), _orders(None))
    beyond, within = _beyond(supply=True), _beyond(supply=False)
    yield no_reading(site, "thermocouple_beyond_supply", beyond, within)
    yield no_reading(site, "chip_too_hot", _is(TOO_HOT_C), _is(USUAL_C))
    yield from conversions(site, site.controller.thermometers[site.loop.sensor].first_s)
    yield slow(site)


def open_s(site: Site) -> float:
    """Return how long the chip may take to find an open thermocouple, s."""
    sensor = site.controller.thermometers[site.loop.sensor]
    return TEST_EVERY * sensor.conversion_s + max(TEST_S.values())


def _broken(site: Site) -> Iterator[Fault]:
    """Yield a thermocouple that breaks just after the chip has tested for an open input.

    Until the next test a capacitor holds the input's voltage, or the voltage goes to 0: the tip
    then seems to be as cold as the chip, and another rule may trip earlier.
    """
    trip = Trip((), answer_s(site.loop) + open_s(site))
    broken = tripping(site, "thermocouple_broken", break_thermocouple, trip, mend_thermocouple)
    broken = replace(broken, make=lambda: _just_tested(site), sensor_lies=True, again=True)
    yield replace(broken, off_within_s=reading_s(site.loop) + open_s(site))
    yield replace(broken, id="thermocouple_broken_at_bias", cause=_break_at_bias)


def _just_tested(site: Site) -> World:
    """Return a world with the heater on, just after the chip tested for an open thermocouple."""
    world = starts.heating(site)
    heats = starts.heater_on(site)
    world.until(lambda now: _chip(now).untested == 1 and heats(now), starts.LONGEST_S)
    return world


def _chip(world: World) -> Max31856:
    return cast("Max31856", chip_of(world))


def _break_at_bias(world: World) -> None:
    _chip(world).held = False
    break_thermocouple(world)


def _orders(level: Level | None) -> Act:
    return lambda world: _chip(world).short_orders(level)


def _beyond(*, supply: bool) -> Act:
    def act(world: World) -> None:
        _chip(world).beyond_supply = supply

    return act


def _is(internal_c: float) -> Act:
    def act(world: World) -> None:
        _chip(world).internal_c = internal_c

    return act
