"""What the binary does in and after a fault is, step by step, what the model does."""

import pytest

from heatwright.sim.faults import catalogue
from heatwright.sim.faults.world import Site
from heatwright.sim.replay import replay

FAULTS = {
    "open": "sensor_open",
    "jump_up": "rise_rate",
    "heater_open": "no_current",
    "switch_leaking": "current_while_off",
    "heater_shorted": "over_current",
    "heater_part_shorted": None,
    "cooler_shorted": "heating_failed",
    "heating_and_cooling_by_turns": None,
    "master_lost": "master_lost",
}
LONGEST_S = 40.0
ON_S = 4.0


@pytest.mark.parametrize("name", FAULTS)
def test_every_step_is_the_models(fabricator_site: Site, name: str) -> None:
    faults = {
        each.id: each for each in catalogue(fabricator_site.controller, fabricator_site.program)
    }
    world = faults[name].make()
    faults[name].cause(world)
    world.until(lambda now: now.fault != 0, LONGEST_S)
    world.run(ON_S)
    faults[name].cure(world)
    world.acknowledge()
    world.run(ON_S)
    world.power_cut()
    world.acknowledge()
    world.run(ON_S)
    result = replay(fabricator_site.controller, world.device.steps(world.site.loop_name))
    assert (result.mismatches, result.segments) == (0, 2), result.first
    assert (world.trips.changes != []) == (FAULTS[name] is not None)


@pytest.mark.parametrize("name", ["relay_dead", "relay_contact_shorted"])
def test_every_step_behind_a_bad_relay_is_the_models(pid_site: Site, name: str) -> None:
    faults = {each.id: each for each in catalogue(pid_site.controller, pid_site.program)}
    world = faults[name].make()
    faults[name].cause(world)
    assert world.until(lambda now: now.fault != 0, LONGEST_S)
    world.run(ON_S)
    world.acknowledge()
    assert world.until(lambda now: now.fault != 0, LONGEST_S)
    faults[name].cure(world)
    world.acknowledge()
    world.run(ON_S)
    assert not world.fault
    result = replay(pid_site.controller, world.device.steps(world.site.loop_name))
    assert (result.mismatches, result.segments) == (0, 1), result.first
