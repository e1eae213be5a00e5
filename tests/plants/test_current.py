"""What a heater takes from its supply, as its sensor sees it."""

import math

import numpy as np
import pytest
from rig.specs import changed, spec_of

from heatwright.sim.bench import ReferenceDevice, bench, step_of
from heatwright.sim.coupling import sums_noise
from heatwright.sim.plants import plant_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import Event, ThermalNetwork

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


QUIET, SINGLE = ("noise: 0.8 K", "noise: 0 K"), ("oversample: 16", "oversample: 1")


def controller(*changes):
    return spec_of(changed("fabricator", *changes)).controller


@pytest.mark.parametrize(
    ("supply", "full_a"), [("43 V", 76.6 / 43), ("43 V, rated: 40 V", 76.6 * 43 / 40**2)]
)
def test_full_current_is_ohms_law(supply, full_a):
    spec = controller(("supply: 43 V", f"supply: {supply}"))
    plant = plant_of(spec, spec.simulation.plant, ambient_c=20.0, step_s=0.1)
    plant.step({"heater": 1.0, "cooler": 0.0})
    assert plant.currents_a() == {"current": pytest.approx(full_a)}


def test_each_of_the_readings_that_are_summed_up_has_its_own_noise():
    for changes in ((QUIET, SINGLE), (SINGLE,), (QUIET,)):
        assert step_of(controller(*changes)) == 0.1
    noisy = controller()
    assert step_of(noisy) == 0.01
    assert sums_noise(noisy, "nozzle")
    assert not sums_noise(noisy, "current")


def test_sums_are_as_much_less_noisy_as_their_number_says():
    """Sixteen readings of noise 1.5 K, and of steps of the ADC, of a block at rest."""
    spec = controller(("noise: 0.8 K", "noise: 1.5 K"))
    trace = bench(spec, ReferenceDevice(spec), [Event.model_validate({"for": "200 s"})])
    readings_c = trace.steps["nozzle"]["temperature_c"]
    step_k = spec.sensors["nozzle"].step_at_k(20.0, spec.board.mcu)
    expected_k = math.sqrt((1.5**2 + step_k**2 / 12) / 16)
    count = len(readings_c)
    assert readings_c.std() == pytest.approx(expected_k, rel=4 / math.sqrt(2 * count))
    assert abs(readings_c.mean() - 20.0) <= step_k / 2
    assert np.all(trace.steps["nozzle"]["duty_percent"] == 0)
