"""What a heater takes from its supply, as its sensor sees it."""

import math

import numpy as np
import pytest

from heatwright.sim.bench import ReferenceDevice, bench, step_of
from heatwright.sim.coupling import sums_noise
from heatwright.sim.plants import plant_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import Event, ThermalNetwork, load_text

BLOCK = {
    "kind": "thermal_network",
    "nodes": {"block": "27 J/K"},
    "links": [{"between": ["block", "ambient"], "resistance": "8 K/W"}],
    "heat": {"heater": "block"},
    "sense": {"tip": {"node": "block"}, "current": {"of": "heater"}},
}
FULL_A = 1.8


def machine(step_s=0.1, **current):
    sense = {**BLOCK["sense"], "current": {"of": "heater", **current}}
    network = ThermalNetwork.model_validate({**BLOCK, "sense": sense})
    full_a = {"heater": FULL_A}
    return Plant(network, {"heater": 80.0}, ambient_c=20.0, step_s=step_s, full_a=full_a)


def test_the_current_is_the_mean_of_the_step():
    plant = machine()
    assert plant.currents_a() == {"current": 0.0}
    for active in (1.0, 0.25, 0.0):
        plant.step({"heater": active})
        assert plant.currents_a()["current"] == pytest.approx(active * FULL_A)


def test_behind_a_filter_it_follows_the_exponential():
    plant = machine(step_s=0.02, lag="100 ms")
    for _ in range(10):
        plant.step({"heater": 1.0})
    expected_a = FULL_A * (1 - math.exp(-0.2 / 0.1))
    assert plant.currents_a()["current"] == pytest.approx(expected_a)


def test_heat_from_elsewhere_takes_no_current():
    plant = machine()
    plant.step({"heater": 1.0}, 0.0, {"heater": 0.5})
    assert plant.currents_a() == {"current": 0.5 * FULL_A}
    assert plant.sensed_c() == {"tip": pytest.approx(20 + 80 * 0.1 / 27, abs=0.001)}


SPEC = """
heatwright: 1
controller: {name: box, board: mega2560}
sensors:
  tip: {kind: rtd, pin: A2, element: pt1000, divider: {pull_up: 2 kΩ}, range: -10 °C .. 400 °C,
        oversample: OVERSAMPLE}
  current: {kind: current, pin: A1, scale: 0.2 V/A, oversample: 4}
outputs:
  heater: {kind: pwm, pin: D5, frequency: 1 kHz, power: 40 W, supply: 24 V, RATED
           current: {sensor: current, limit: 3 A}}
loops:
  tip:
    sensor: tip
    heater: heater
    period: 400 ms
    setpoint: {initial: 100 °C, minimum: 30 °C, maximum: 200 °C}
    algorithm: {kind: on_off, hysteresis: 2 K}
    protection: {rise_rate: 20 K/s, minimum: -5 °C}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {block: 27 J/K}
    links: [{between: [block, ambient], resistance: 8 K/W}]
    heat: {heater: block}
    sense: {tip: {node: block, lag: 3 s, noise: NOISE}, current: {of: heater}}
  scenario: [{for: 10 s}]
"""


def controller(*, oversample=1, noise="0 K", rated=""):
    text = SPEC.replace("OVERSAMPLE", str(oversample)).replace("NOISE", noise)
    return load_text(text.replace("RATED", rated), "box.yaml").controller


@pytest.mark.parametrize(("rated", "full_a"), [("", 40 / 24), ("rated: 20 V,", 40 * 24 / 20**2)])
def test_full_current_is_ohms_law(rated, full_a):
    spec = controller(rated=rated)
    plant = plant_of(spec, spec.simulation.plant, ambient_c=20.0, step_s=0.1)
    plant.step({"heater": 1.0})
    assert plant.currents_a() == {"current": pytest.approx(full_a)}


def test_each_of_the_readings_that_are_summed_up_has_its_own_noise():
    assert step_of(controller()) == 0.2
    assert step_of(controller(noise="1 K")) == 0.2
    assert step_of(controller(oversample=16)) == 0.2
    noisy = controller(oversample=16, noise="1 K")
    assert step_of(noisy) == 0.01
    assert sums_noise(noisy, "tip")
    assert not sums_noise(noisy, "current")


def test_sums_are_as_much_less_noisy_as_their_number_says():
    """Sixteen readings of noise 1 K, and of steps of 2 K of the ADC, of a block at rest."""
    spec = controller(oversample=16, noise="1.5 K")
    loop = spec.loops["tip"]
    cold = loop.model_copy(update={"setpoint": loop.setpoint.model_copy(update={"initial_c": 5.0})})
    spec = spec.model_copy(update={"loops": {"tip": cold}})
    trace = bench(spec, ReferenceDevice(spec), [Event.model_validate({"for": "400 s"})])
    readings_c = trace.steps["tip"]["temperature_c"]
    step_k = spec.sensors["tip"].step_at_k(20.0, spec.board.mcu)
    expected_k = math.sqrt((1.5**2 + step_k**2 / 12) / 16)
    count = len(readings_c)
    assert readings_c.std() == pytest.approx(expected_k, rel=4 / math.sqrt(2 * count))
    assert abs(readings_c.mean() - 20.0) <= step_k / 2
    assert np.all(trace.steps["tip"]["duty_percent"] == 0)
