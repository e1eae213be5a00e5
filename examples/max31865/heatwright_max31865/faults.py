"""A MAX31865's faults, and those of its element and wires."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from heatwright.sim.faults.fault import Act, Fault
from heatwright.sim.faults.sensing.converter import (
    WATCH_S,
    chip_of,
    conversions,
    failing_supply,
    wires,
)
from heatwright.sim.faults.sensing.converter import cut as break_element
from heatwright.sim.faults.sensing.converter import mend as mend_element
from heatwright.sim.faults.sensing.readings import no_reading, slow_conversions
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.pins import Level
from heatwright_max31865.simulated import Max31865

SLOW = 1.5


def cut(world: World) -> None:
    """Break the element."""
    break_element(world)


def mend(world: World) -> None:
    """Weld it again."""
    mend_element(world)


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to the loop's sensor."""
    yield from wires(site)
    yield no_reading(site, "element_broken", cut, mend)
    yield no_reading(site, "element_shorted", _shorted(is_so=True), _shorted(is_so=False))
    yield no_reading(site, "element_beyond_supply", _beyond(is_so=True), _beyond(is_so=False))
    yield no_reading(site, "orders_shorted_to_supply", _orders("high"), _orders(None))
    yield failing_supply(site)
    yield from conversions(site, site.controller.thermometers[site.loop.sensor].first_s)
    yield slow_conversions(site, _slow, WATCH_S)


def _chip(world: World) -> Max31865:
    return cast("Max31865", chip_of(world))


def _shorted(*, is_so: bool) -> Act:
    def act(world: World) -> None:
        _chip(world).settle()
        _chip(world).shorted = is_so

    return act


def _beyond(*, is_so: bool) -> Act:
    def act(world: World) -> None:
        _chip(world).settle()
        _chip(world).beyond_supply = is_so

    return act


def _orders(level: Level | None) -> Act:
    return lambda world: _chip(world).short_orders(level)


def _slow(world: World) -> None:
    chip_of(world).faults.slow = SLOW
