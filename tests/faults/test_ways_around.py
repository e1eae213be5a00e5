"""Ways around the protection."""

import pytest
from any_machine.drawing import MACHINES
from fault_machines import site_of
from rig.firmware import ROOT, changed, edited

from heatwright.sim.bench import ReferenceDevice
from heatwright.sim.faults import starts
from heatwright.sim.faults.effects import SHORTED
from heatwright.sim.faults.machine import steady_c
from heatwright.sim.faults.world import Weather, World

DOCS = ROOT / "docs"
SIX_SIGMA_K = 6 * 0.8  # six standard deviations of the machine's noise
COLD_C = 50.0  # where the cooler's work is done
COOLED_S = 600.0  # ten time constants of the cooled block
LIMIT_A = 2.5
RAMP_PERCENT = 25.0
SETTLED_S = 6.0  # five times what a limited heater takes to its limit, and more


STRONG = edited(
    "fabricator", "{outputs.supply_relay: null, safety.relay: null, safety.relay_feedback: null}"
)
"""It can give the wire the whole supply, which is (43/25.57)² of its power."""
WEAK = edited(STRONG, "outputs.heater.rated: null")
"""The same power from the whole supply: all that a switch that has died can give."""


def died(spec: str) -> World:
    """A switch that has died while it heats, ten time constants after the fault."""
    world = starts.heating(site_of(spec))
    world.wiring.heat["heater"] = SHORTED
    world.switch(on=False)
    world.until(lambda now: now.fault != 0, 10.0)
    world.run(COOLED_S)
    return world


def test_a_switch_that_conducts_for_ever_gets_nothing_behind_an_open_relay() -> None:
    world = died("fabricator")
    _, flowed_a = world.told("current")
    assert flowed_a[-1] == pytest.approx(0.0, abs=1e-6)
    assert world.sensed_c < COLD_C


@pytest.mark.parametrize("spec", [WEAK, STRONG])
def test_without_a_relay_it_is_cooled_to_where_the_whole_supply_holds_it(spec: str) -> None:
    """A cooler that is as strong as the rated power does not suffice for a stronger supply."""
    world = died(spec)
    site, ambient_c = world.site, world.site.ambient_c
    cooled_c, uncooled_c = (
        steady_c(site, 1.0, ambient_c=ambient_c, cooled=cooled) for cooled in (True, False)
    )
    assert world.sensed_c == pytest.approx(cooled_c, abs=SIX_SIGMA_K)
    assert (cooled_c < site.loop.protection.maximum_c) is (spec == WEAK)
    if spec == STRONG:
        told = f"settle at {cooled_c:.0f} °C with its cooler on"
        assert all(
            told in (DOCS / page).read_text("utf-8") for page in ("evidence.md", "safety.md")
        )
    assert uncooled_c > site.loop.protection.maximum_c


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


def test_a_touch_on_stop_is_not_undone_by_a_master_that_repeats_on() -> None:
    """It released the loop, as a master's own OFF does; a touch on ON needs no release."""
    lines = "[{kind: modbus_rtu, address: 1, baud: 9600}, {kind: nextion, loop: air, port: 1}]"
    site = site_of(edited(MACHINES["hatcher"], f"interfaces: {lines}"))
    world = World(site, Weather(site.ambient_c, site.ambient_c))
    model = ReferenceDevice(site.controller)
    world.run(5.0)

    def after(touch: str) -> tuple[float, bool]:
        """Return whether the loop is on, and the model's, if a master then repeats ON."""
        world.device.send(touch)
        model.send(touch)
        for _ in range(3):
            world.run(1.0)
            world.device.master.ask(world.device.master.request("air.enabled", value=True).pdu)
            model._loops["air"].operator.enable()
        world.run(1.0)
        return world.loop("enabled"), not model._loops["air"].operator.is_off

    touches = ("#22;", "#17;", "#2 1;", "#17;", "#2 1;", "#2 0;")
    assert [after(touch) for touch in touches] == [(0, 0), (0, 0), (1, 1), (0, 0), (1, 1), (0, 0)]
