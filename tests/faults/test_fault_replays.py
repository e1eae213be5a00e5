"""What the binary does in and after a fault is, step by step, what the model does."""

import pytest
from fault_machines import expected, faults_of

from heatwright.sim.faults.world import World
from heatwright.sim.replay import replay

FAULTS = (
    "open", "jump_up", "heater_open", "switch_leaking", "heater_shorted", "heater_part_shorted",
    "cooler_shorted", "heating_and_cooling_by_turns", "master_lost",
)  # fmt: skip
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


def differences(world: World) -> tuple[int, int, object]:
    """How many steps differ from the model's, in how many runs; the first of them."""
    site = world.site
    result = replay(site.controller, world.device.steps(site.loop_name))
    return result.mismatches, result.segments, result.first


@pytest.mark.parametrize("name", FAULTS)
def test_every_step_is_the_models(name: str) -> None:
    world = begun("fabricator", name)
    faults_of("fabricator")[name].cure(world)
    world.acknowledge()
    world.run(ON_S)
    world.power_cut()
    world.acknowledge()
    world.run(ON_S)
    assert differences(world) == (0, 2, ())


@pytest.mark.parametrize("name", ["relay_dead", "relay_contact_shorted"])
def test_every_step_behind_a_bad_relay_is_the_models(name: str) -> None:
    world = begun("pid", name)
    world.acknowledge()
    assert world.until(lambda now: now.fault != 0, LONGEST_S)
    faults_of("pid")[name].cure(world)
    world.acknowledge()
    world.run(ON_S)
    assert not world.fault
    assert differences(world) == (0, 1, ())
