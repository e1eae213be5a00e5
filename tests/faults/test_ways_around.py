"""Ways around the protection; and every step in and after a fault is the model's."""

import pytest
from fault_machines import expected, faults_of, site_of
from rig.specs import changed

from heatwright.sim.faults import starts
from heatwright.sim.faults.effects import shorted
from heatwright.sim.faults.machine import steady_c
from heatwright.sim.faults.world import Weather, World
from heatwright.sim.replay import ReplayResult, replay

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


# ---- what the binary does in and after a fault is, step by step, what the model does ----

FAULTS = {
    "fabricator": (
        "open", "jump_up", "heater_open", "switch_leaking", "heater_shorted",
        "heater_part_shorted", "cooler_shorted", "heating_and_cooling_by_turns", "master_lost",
    ),
    "kiln": (
        "sensor_lost_in_program", "power_cut_in_program", "power_cut_until_cold",
        "power_cut_in_pause",
    ),
}  # fmt: skip
LONGEST_S = 40.0
ON_S = 4.0


def begun(machine: str, name: str) -> World:
    """Cause a fault, and wait for what it trips."""
    fault = faults_of(machine)[name]
    world = fault.make()
    fault.cause(world)
    assert world.until(lambda now: now.fault != 0, LONGEST_S) == bool(expected(machine)[name])
    world.run(ON_S)
    return world


def replayed(world: World) -> ReplayResult:
    return replay(world.site.controller, world.device.steps(world.site.loop_name))


@pytest.mark.parametrize(
    ("machine", "name"), [(machine, name) for machine in FAULTS for name in FAULTS[machine]]
)
def test_every_step_is_the_models(machine: str, name: str) -> None:
    """A fault outlives a loss of power; once acknowledged, it does not outlive another."""
    world = begun(machine, name)
    code = world.fault
    world.power_cut()
    world.run(ON_S)
    faults_of(machine)[name].cure(world)
    world.run(ON_S)  # to be well again is a jump, too
    world.acknowledge()
    world.run(ON_S)
    world.power_cut()
    world.acknowledge()
    world.run(ON_S)
    result = replayed(world)
    assert result.first == ()
    assert result.segments == (4 if name.startswith("power_cut") else 3)
    assert [each.fault_code for each in result.restored] == ([code] if code else [])


@pytest.mark.parametrize("name", ["relay_dead", "relay_contact_shorted"])
def test_every_step_behind_a_bad_relay_is_the_models(name: str) -> None:
    """One that fails while the power is away is no fault that outlived it."""
    world = begun("pid", name)
    world.acknowledge()
    assert world.until(lambda now: now.fault != 0, LONGEST_S)
    fault = faults_of("pid")[name]
    fault.cure(world)
    world.acknowledge()
    world.run(ON_S)
    assert not world.fault
    fault.cause(world)
    world.power_cut()
    assert world.until(lambda now: now.fault != 0, LONGEST_S)
    result = replayed(world)
    assert (result.first, result.segments, result.restored) == ((), 2, ())
