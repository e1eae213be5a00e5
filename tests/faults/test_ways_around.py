"""Ways around the protection: by hand, through a cooler, off and on between two steps."""

import pytest
from fault_machines import site_of
from rig.specs import changed

from heatwright.sim.faults import starts
from heatwright.sim.faults.effects import shorted
from heatwright.sim.faults.machine import steady_c
from heatwright.sim.faults.world import Weather, World
from heatwright.sim.reference.guard_rules import FROZEN

SIX_SIGMA_K = 6 * 0.8
"""Of the machine's noise."""
COOLED_S = 600.0
"""Ten time constants of the cooled block."""
LIMIT_A = 1.2
RAMP_PERCENT = 25.0
SETTLED_S = 6.0
"""Five times what a limited heater takes to its limit, and more."""


@pytest.mark.parametrize("duty_percent", [30, 99])
def test_a_dead_sensor_trips_where_nobody_regulates(duty_percent: int) -> None:
    world = World(site_of("extruder"), Weather(start_c=150.0, ambient_c=20.0))
    loop = world.site.loop
    assert loop.protection.frozen is not None
    world.send(f"M104 D{duty_percent}")
    world.run(1.0)
    stuck_c = world.tip_c
    world.wiring.feel[loop.sensor] = lambda _felt_c: stuck_c
    bound_s = loop.protection.frozen.for_s + 2 * loop.period_s
    assert world.until(lambda now: now.fault != 0, bound_s + 0.1)
    assert world.fault == FROZEN


def test_a_switch_that_conducts_for_ever_is_cooled_to_where_it_burns_nothing() -> None:
    site = site_of("fabricator")
    world = starts.heating(site)
    world.wiring.heat["heater"] = shorted
    world.switch(on=False)
    world.until(lambda now: now.fault != 0, 10.0)
    world.run(COOLED_S)
    ambient_c = starts.ambient_c(site)
    cooled_c, uncooled_c = (
        steady_c(site, 1.0, ambient_c=ambient_c, cooled=cooled) for cooled in (True, False)
    )
    assert world.sensed_c == pytest.approx(cooled_c, abs=SIX_SIGMA_K)
    assert cooled_c < site.loop.protection.maximum_c < uncooled_c


@pytest.mark.parametrize("after_s", [0.0, 0.05, 0.1])
def test_off_and_on_is_no_way_around_the_limit(after_s: float) -> None:
    """What was not on shows no current, and would have given the next step too much duty."""
    site = site_of(changed("fabricator", ("limit: 3 A", f"limit: {LIMIT_A} A")))
    world = World(site, Weather(100.0, 20.0))
    world.run(1.0)
    world.set_setpoint(250.0)
    world.run(SETTLED_S + after_s)
    assert RAMP_PERCENT < world.loop("duty_percent") < 100.0
    master = world.device.master
    for on in (False, True):
        master.ask(master.request("nozzle.enabled", value=on).pdu)
    for _ in range(2):
        world.run(world.site.loop.period_s)
        assert world.loop("duty_percent") <= RAMP_PERCENT
    world.run(SETTLED_S)
    assert world.fault == 0
    assert world.loop("duty_percent") > RAMP_PERCENT
