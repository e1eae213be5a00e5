"""What the binary does in and after a fault is, step by step, what the model does."""

import pytest
from fault_machines import expected, faults_of

from heatwright.sim.faults.world import World
from heatwright.sim.replay import ReplayResult, replay

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
