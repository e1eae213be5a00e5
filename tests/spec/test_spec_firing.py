"""The check of ramps: what a ramp takes, what the best of controls makes of it, what is advised."""

import re
from pathlib import Path

import pytest

from heatwright.spec import (
    Controller,
    SpecError,
    ThermalNetwork,
    TimeProportionalOutput,
    load_text,
)
from heatwright.spec.checks import firing
from heatwright.spec.checks.firing import Ramp
from heatwright.spec.checks.machine import Machine
from heatwright.spec.network import Heated

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
KILN = (EXAMPLES / "kiln.yaml").read_text(encoding="utf-8")
FIRST = "{to: 540 °C, over: 60 min}"


def kiln(first: str = FIRST, power: str = "484 W") -> Controller:
    assert KILN.count(FIRST) == 1
    return load_text(KILN.replace(FIRST, first).replace("484 W", power)).controller


def machine_of(controller: Controller) -> Machine:
    heater = controller.outputs["element"]
    assert isinstance(heater, TimeProportionalOutput)
    assert controller.simulation is not None
    return Machine(controller, "chamber", heater, controller.simulation)


@pytest.fixture(scope="module")
def machine() -> Machine:
    return machine_of(kiln())


def ramp(to_k: float, seconds: float) -> Ramp:
    return Ramp((), "over", 0.0, to_k, seconds)


def test_a_ramp_warms_all_and_makes_up_for_losses() -> None:
    """One node, 100 J/K behind 0.5 K/W; a sensor that lags by 10 s is behind by rate · 10 s."""
    plant = ThermalNetwork.model_validate(
        {
            "kind": "thermal_network",
            "nodes": {"body": "100 J/K"},
            "links": ({"between": ("body", "ambient"), "resistance": "0.5 K/W"},),
            "heat": {"heater": "body"},
            "sense": {"probe": {"node": "body", "lag": "10 s"}},
        }
    )
    heated = Heated(plant, "heater", "probe", 20.0)
    assert heated.ramp_power_w(300.0, 0.2) == pytest.approx(100 * 0.2 + (300 + 2) / 0.5)
    assert heated.ramp_power_w(300.0, 0.0) == pytest.approx(heated.power_w(300.0))
    assert heated.answer_s() == pytest.approx(50 + 10)


def test_at_rest_nothing_moves(machine: Machine) -> None:
    state = machine.plant.rest(600.0)
    later = machine.plant.advance(state, machine.plant.power_w(600.0), 3600.0)
    assert later == pytest.approx(state, rel=1e-9)
    assert machine.plant.sensed_k(state) == pytest.approx(600.0)


def test_the_best_of_controls_keeps_up_where_it_can(machine: Machine) -> None:
    assert firing._lost_after_s(machine, ramp(520.0, 3600.0), within_k=5.0) is None
    lost_s = firing._lost_after_s(machine, ramp(520.0, 720.0), within_k=10.0)
    assert lost_s is not None
    later_s = firing._lost_after_s(machine, ramp(520.0, 720.0), within_k=20.0)
    assert later_s is not None
    assert later_s > lost_s


def test_ramps_up_are_looked_at_and_no_others(machine: Machine) -> None:
    controller = kiln()
    assert controller.programs is not None
    ways = [(way.from_k, way.to_k) for way in firing._ramps(machine, controller.programs)]
    assert ways == [(0.0, 520.0), (520.0, 780.0)]


@pytest.mark.parametrize(
    ("steep", "form"),
    [
        ("over: 12 min", "over: {} min"),
        ("at: 2600 K/h", "at: {} K/h"),
    ],
)
def test_the_advice_is_good(steep: str, form: str) -> None:
    with pytest.raises(SpecError) as caught:
        kiln(f"{{to: 540 °C, {steep}}}")
    (problem,) = caught.value.problems
    assert "W cannot follow" in problem.reason
    advised = re.search(r"Use at (?:least|most) ([0-9.]+) ", problem.remedy)
    assert advised is not None
    assert kiln(f"{{to: 540 °C, {form.format(advised[1])}}}")


def test_more_power_follows() -> None:
    assert kiln("{to: 540 °C, over: 12 min}", "700 W")


def test_no_power_is_enough_for_the_last_degree(machine: Machine) -> None:
    highest_k = machine.plant.steady_k(machine.full_power_w)
    assert "more power" in firing._slower(machine, ramp(highest_k + 1.0, 3600.0))
