"""Faults of a heater's current sensor: its line is torn or shorted, or its output is stuck."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

from heatwright.sim.circuits import Wiring
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import reading_s
from heatwright.sim.faults.fault import Act, Fault, Trip, tripping, watched
from heatwright.sim.faults.machine_parts.currents import measured
from heatwright.sim.faults.world import Site, World
from heatwright.sim.sensors.current import CurrentProbe
from heatwright.spec import Current


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the sensor of the heater's current."""
    torn, sound = _wire(Wiring(opened=True)), _wire(Wiring())
    yield replace(watched(site, "current_sensor_torn", torn, sound), current_lies=True)
    high, trip = _wire(Wiring(pin="high")), Trip(("over_current",), reading_s(site.loop))
    at_supply = tripping(site, "current_sensor_at_supply", high, trip, sound)
    yield replace(at_supply, current_lies=True, again=True)
    if site.is_set:
        stands = watched(site, "current_sensor_stands", _stand, _let_go)
        yield replace(stands, current_lies=True, again=False)


def _current(site: Site) -> Current:
    return cast("Current", site.facts.current)


def _probe(world: World) -> CurrentProbe:
    return cast("CurrentProbe", world.device.sensors[_current(world.site).sensor])


def _wire(wiring: Wiring) -> Act:
    def act(world: World) -> None:
        _probe(world).wiring = wiring

    return act


def _stand(world: World) -> None:
    """Hold the sensor's output while the heater is on, and set the lowest setpoint."""
    heater = measured(world.site)
    assert heater is not None  # noqa: S101 - this sensor measures it
    world.until(lambda now: _probe(now).amperes >= 2 * heater.idle_a, starts.LONGEST_S)
    _probe(world).stands = True
    world.set_setpoint(starts.setpoints_c(world.site)[0])


def _let_go(world: World) -> None:
    _probe(world).stands = False
