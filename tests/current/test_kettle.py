"""Machines with a measured current: each fault of its sensor, and the state that is timed."""

import pytest
from rig.avr import whole
from rig.specs import example, spec_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.faults.world import Site
from heatwright.sim.timing.stage import Stage

SPEC = """
heatwright: 1
controller: {name: kettle, board: uno}
sensors:
  water:
    kind: thermistor
    pin: A1
    divider: {pull_up: 4.7 kΩ}
    curve: {resistance: 10 kΩ, at: 25 °C, beta: 3950 K}
    range: 0 °C .. 150 °C
    oversample: 8
  amps: {kind: current, pin: A2, scale: 0.25 V/A}
outputs:
  heater: {HEATER, pin: D3, power: 240 W, supply: 24 V, current: {sensor: amps, CURRENT}}
loops:
  water:
    sensor: water
    heater: heater
    period: 500 ms
    setpoint: {initial: 40 °C, minimum: 30 °C, maximum: 90 °C}
    algorithm: {ALGORITHM}
    protection: {minimum: 3 °C, rise_rate: 10 K/s}
interfaces:
  - {kind: lcd_keypad, loop: water, step: 10 K}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {jug: 1000 J/K}
    links:
      - {between: [jug, ambient], resistance: 1 K/W}
    heat: {heater: jug}
    sense: {water: {node: jug, lag: 2 s}, amps: {of: heater, lag: 20 ms}}
  scenario:
    - {for: 100 s}
"""
KETTLES = {
    "limited": ("kind: pwm, frequency: 976.5625 Hz", "limit: 8 A",
                "kind: pid, kp: 20, ki: 0.1"),
    "tripped": ("kind: digital", "trip: 12 A", "kind: on_off, hysteresis: 1 K"),
}  # fmt: skip
"""Heater, current and algorithm."""


def kettle(name: str) -> Site:
    heater, current, algorithm = KETTLES[name]
    text = SPEC.replace("HEATER", heater).replace("CURRENT", current)
    text = text.replace("ALGORITHM", algorithm)
    return Site(spec_of(text).controller, whole(text), "water")


RULES = {
    "current_sensor_torn": "no_current",
    "current_sensor_at_supply": "over_current",
    "current_sensor_stands": "current_while_off",
}


@pytest.fixture(scope="module", params=KETTLES)
def site(request: pytest.FixtureRequest) -> Site:
    return kettle(request.param)


@pytest.mark.parametrize(("name", "rule"), RULES.items())
def test_it_trips(site: Site, name: str, rule: str) -> None:
    found = {fault.id: fault for fault in catalogue(site.controller, site.program)}
    result = try_fault(found[name])
    assert result.detail == ""
    assert result.rule == rule


@pytest.mark.parametrize("name", KETTLES)
def test_it_is_timed_while_it_heats(name: str) -> None:
    site = kettle(name)
    device = AvrDevice(site.controller, site.program)
    stage, heated = Stage(site.controller, device), 0
    stage.advance(5.0)
    device.press("up")
    for second in range(6, 110):
        stage.advance(second)
        device.press(None)
        heated += device.read("current_heater.applied_percent") > 0
        assert not device.read("fault.code")
    assert heated >= 30


@pytest.mark.parametrize("name", ["fabricator", "dryer"])
def test_what_a_master_switches_is_on(name: str) -> None:
    controller = example(name).controller
    device = AvrDevice(controller, whole(name))
    Stage(controller, device).advance(60.0)
    ((loop, _),) = controller.loops.items()
    assert device.read(f"loop_{loop}.enabled") == 1
    assert not device.read("fault.code")
