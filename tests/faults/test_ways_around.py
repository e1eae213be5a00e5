"""Ways around the protection."""

import pytest
from fault_machines import site_of
from rig.specs import changed

from heatwright.sim.faults import starts
from heatwright.sim.faults.effects import shorted
from heatwright.sim.faults.machine import steady_c
from heatwright.sim.faults.world import Weather, World

SIX_SIGMA_K = 6 * 0.8
"""Of the machine's noise."""
COOLED_S = 600.0
"""Ten time constants of the cooled block."""
LIMIT_A = 1.2
RAMP_PERCENT = 25.0
SETTLED_S = 6.0
"""Five times what a limited heater takes to its limit, and more."""


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
