"""Healthy machines that are warm: at rest for hours, and a little above what holding needs."""

import pytest
from rig.specs import EXAMPLES, controller_of, spec_of

from heatwright.sim.bench import bench
from heatwright.sim.plants import full_power, plant_of
from heatwright.sim.reference.device import ReferenceDevice
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

BATH = """
heatwright: 1
controller: {name: bath, board: mega2560}
sensors: {water: {kind: ds18b20, pin: A1}}
outputs: {heater: {kind: time_proportional, pin: D3, window: 2 s, power: 1500 W}}
loops:
  water:
    sensor: water
    heater: heater
    period: 1 s
    setpoint: {initial: 85.1 °C, minimum: 20 °C, maximum: 90 °C}
    algorithm: {kind: pid, kp: 20, ki: 0.005}
    protection: {heating: {rise: 0.2 K, within: 5 min}}
interfaces: [{kind: serial_plotter, loop: water, baud: 9600}]
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {water: 60 kJ/K}
    links: [{between: [water, ambient], resistance: 0.15 K/W}]
    heat: {heater: water}
    sense: {water: {node: water, lag: 10 s}}
    initial: 84 °C
  scenario: [{for: 3 h}]
"""


def with_old_rule(controller: Controller) -> Controller:
    """As where no plant is given: any heat counts."""
    loop = controller.loops["water"]
    frozen = loop.protection.frozen.model_copy(update={"holding_percent": 0.0, "for_s": 600.0})
    protection = loop.protection.model_copy(update={"frozen": frozen})
    loops = {"water": loop.model_copy(update={"protection": protection})}
    return controller.model_copy(update={"loops": ReadOnlyDict(loops)})


def test_a_reading_may_stand_still_while_heat_only_holds() -> None:
    """Under the rule that counts any heat this healthy bath trips after an hour and a half."""
    bath = spec_of(BATH).controller
    for controller, code in ((bath, 0), (with_old_rule(bath), 9)):
        log = bench(controller, ReferenceDevice(controller), step_s=1.0).steps["water"]
        assert log["fault.code"].max() == code


HELD = [
    (path.stem, name)
    for path in sorted(EXAMPLES.glob("*.yaml"))
    for name, loop in controller_of(path.stem).loops.items()
    if loop.protection.frozen is not None
]


@pytest.mark.parametrize(("name", "loop_name"), HELD)
def test_heat_beyond_holding_moves_the_reading(name: str, loop_name: str) -> None:
    """Up to the highest setpoint, by a step within the time that the rule leaves it."""
    controller = controller_of(name)
    loop = controller.loops[loop_name]
    simulation, frozen = controller.simulation, loop.protection.frozen
    sensor = controller.thermometers[loop.sensor]
    step_k = sensor.step_at_k(loop.setpoint.maximum_c, controller.board.mcu)
    plant = plant_of(controller, simulation.plant, ambient_c=simulation.ambient_c, step_s=1.0)
    still = {
        output: 0.0
        for output, each in controller.outputs.items()
        if getattr(each, "runs", "with_loop") != "always"
    }
    asked = full_power(controller, loop_name) | still
    asked[loop.heater] = frozen.holding_percent / 100
    last_c, still_s = plant.sensed_c()[loop.sensor], 0
    while last_c < loop.setpoint.maximum_c:
        plant.step(asked)
        still_s += 1
        if abs(plant.sensed_c()[loop.sensor] - last_c) >= step_k:
            last_c, still_s = plant.sensed_c()[loop.sensor], 0
        assert still_s < frozen.for_s
