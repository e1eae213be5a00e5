"""A healthy machine that another loop warms."""

from rig.firmware import spec_of

from heatwright.sim.bench import bench
from heatwright.sim.reference.device import ReferenceDevice
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

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


def test_what_the_plant_says_does_not_trip_in_health() -> None:
    """Where nothing is known of the plant, the rules count any rise of one that another warms."""
    spec = spec_of(TWO_ZONES).controller
    for machine, expected in ((spec, {0}), (with_old_rules(spec), {11, 13})):
        log = bench(machine, ReferenceDevice(machine), step_s=1.0).steps["lower"]
        assert log["fault.code"].max() in expected
