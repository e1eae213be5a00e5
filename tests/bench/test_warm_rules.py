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


SOUS_VIDE = (
    BATH.replace("protection: {heating: {rise: 0.2 K, within: 5 min}}", "protection: {}")
    .replace("initial: 84 °C", "initial: 63 °C")
    .replace("{for: 3 h}", "{for: 30 min}")
)
"""So much of it is water that two kelvins take long, above all after a power cut."""

TWO_ZONES = """
heatwright: 1
controller: {name: rollers, board: mega2560}
sensors: {upper: {kind: ds18b20, pin: D22}, lower: {kind: ds18b20, pin: D23}}
outputs:
  upper_heater: {kind: time_proportional, pin: D30, window: 2 s, power: 150 W}
  lower_heater: {kind: time_proportional, pin: D31, window: 2 s, power: 150 W}
loops:
  upper:
    sensor: upper
    heater: upper_heater
    period: 1 s
    setpoint: {initial: 100 °C, minimum: 40 °C, maximum: 100 °C}
    algorithm: {kind: pid, kp: 10, ki: 0.05}
  lower:
    sensor: lower
    heater: lower_heater
    period: 1 s
    setpoint: {initial: 40 °C, minimum: 40 °C, maximum: 100 °C}
    algorithm: {kind: pid, kp: 10, ki: 0.05}
interfaces: [{kind: serial_plotter, loop: upper, baud: 9600}]
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {upper: 500 J/K, lower: 500 J/K}
    links:
      - {between: [upper, lower], resistance: 1 K/W}
      - {between: [upper, ambient], resistance: 1.2 K/W}
      - {between: [lower, ambient], resistance: 1.2 K/W}
    heat: {upper_heater: upper, lower_heater: lower}
    sense: {upper: {node: upper, lag: 3 s}, lower: {node: lower, lag: 3 s}}
  scenario: [{for: 40 min}]
"""


def with_old_rules(controller: Controller) -> Controller:
    """Give all rules the numbers that they have where no plant is given."""
    loops = {}
    for name, loop in controller.loops.items():
        rules = {
            rule: type(limits)()
            for rule in ("heating", "frozen", "runaway", "rising_while_off")
            if (limits := getattr(loop.protection, rule)).derived
        }
        protection = loop.protection.model_copy(update=rules)
        loops[name] = loop.model_copy(update={"protection": protection})
    return controller.model_copy(update={"loops": ReadOnlyDict(loops)})


@pytest.mark.parametrize(
    ("text", "heavier", "loop", "codes"),
    [
        (BATH, 1.0, "water", {9}),
        (SOUS_VIDE, 1.3, "water", {10}),
        (TWO_ZONES, 1.0, "lower", {11, 13}),
    ],
    ids=["holds", "heavier", "warmed_by_the_other"],
)
def test_what_the_plant_says_does_not_trip_in_health(
    text: str, heavier: float, loop: str, codes: set[int]
) -> None:
    """Where nothing is known of the plant, the rules count any heat, any time, any rise."""
    spec = spec_of(text).controller
    nodes = {node: heavier * each for node, each in spec.simulation.plant.nodes.items()}
    plant = spec.simulation.plant.model_copy(update={"nodes": nodes})
    simulation = spec.simulation.model_copy(update={"plant": plant})
    for rules, expected in ((spec, {0}), (with_old_rules(spec), codes)):
        machine = rules.model_copy(update={"simulation": simulation})
        log = bench(machine, ReferenceDevice(machine), step_s=1.0).steps[loop]
        assert log["fault.code"].max() in expected


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
