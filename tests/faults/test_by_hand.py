"""Heating by hand: nobody regulates, and a dead sensor must still not burn the house down."""

import pytest

from heatwright.sim.faults.world import Site, Weather, World
from heatwright.sim.reference.guard_rules import FROZEN


@pytest.mark.parametrize("duty_percent", [30, 99])
def test_a_reading_that_stands_still_trips(extruder_site: Site, duty_percent: int) -> None:
    loop = extruder_site.loop
    assert loop.protection.frozen is not None
    world = World(extruder_site, Weather(start_c=150.0, ambient_c=20.0))
    world.send(f"M104 D{duty_percent}")
    world.run(1.0)
    stuck_c = world.tip_c
    world.wiring.feel[loop.sensor] = lambda _felt_c: stuck_c
    bound_s = loop.protection.frozen.for_s + 2 * loop.period_s
    assert world.until(lambda now: now.fault != 0, bound_s + 0.1)
    assert world.fault == FROZEN
