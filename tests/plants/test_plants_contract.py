"""Every kind of plant that the language knows can be simulated."""

from importlib import import_module

import pytest

from heatwright.sim.plants import plant_of
from heatwright.spec import Plant, kinds


@pytest.mark.parametrize("kind", kinds(Plant))
def test_every_plant_of_the_language_has_its_module(kind):
    assert import_module(f"heatwright.sim.plants.{kind}").Plant


@pytest.mark.parametrize("example", ["chamber", "oven"])
def test_a_plant_has_temperatures_for_its_nodes_and_sensors(request, example):
    controller = request.getfixturevalue(example)
    simulation = controller.simulation
    plant = plant_of(controller, simulation.plant, ambient_c=simulation.ambient_c, step_s=0.1)
    assert plant.nodes == tuple(simulation.plant.nodes)
    assert len(plant.temperatures_c) == len(plant.nodes)
    assert plant.sensed_c().keys() == controller.sensors.keys()
    before = float(plant.temperatures_c.max())
    for _ in range(100):
        plant.step(dict.fromkeys(controller.outputs, 1.0))
    assert float(plant.temperatures_c.max()) > before
