"""The physics of the checks: what a machine does by itself, and whether it follows a ramp."""

import re
from itertools import pairwise

import pytest
from rig.bad_specs import bases
from rig.specs import changed, controller_of, example

from heatwright.spec import Controller, SpecError, Stepper
from heatwright.spec.checks import firing
from heatwright.spec.checks.firing import Ramp
from heatwright.spec.checks.machine import Machine

FIRST = "{to: 540 °C, over: 60 min}"


def machine_of(controller: Controller) -> Machine:
    name, loop = next(iter(controller.loops.items()))
    heater = controller.outputs[loop.heater]
    assert not isinstance(heater, Stepper)
    assert controller.simulation is not None
    return Machine(controller, name, heater, controller.simulation)


def test_a_cooler_cools_faster() -> None:
    """At 320 °C the block alone falls by θ/(R·C); with the cooler by four times that.

    The sensor follows with its lag, so it never falls as fast as the block at the start.
    """
    alone_k_per_s = 300 / (8 * 27)
    course = machine_of(controller_of(bases()["simulated_fabricator"])).cooling()
    steepest = max(
        (before - after) / (after_s - before_s)
        for (before_s, before), (after_s, after) in pairwise(course)
    )
    assert alone_k_per_s < steepest < 4 * alone_k_per_s


def kiln(first: str = FIRST) -> Controller:
    return controller_of(changed(bases()["simulated_kiln"], (FIRST, first)))


@pytest.fixture(scope="module")
def machine() -> Machine:
    return machine_of(kiln())


def ramp(to_k: float, seconds: float) -> Ramp:
    return Ramp((), "over", 0.0, to_k, seconds)


def test_at_rest_nothing_moves(machine: Machine) -> None:
    state = machine.plant.rest(600.0)
    later = machine.plant.advance(state, machine.plant.power_w(600.0), 3600.0)
    assert later == pytest.approx(state, rel=1e-9)
    assert machine.plant.sensed_k(state) == pytest.approx(600.0)


def test_the_best_of_controls_keeps_up_where_it_can(machine: Machine) -> None:
    assert firing._lost_after_s(machine, ramp(520.0, 3600.0), within_k=5.0) is None
    lost_s = firing._lost_after_s(machine, ramp(520.0, 720.0), within_k=10.0)
    later_s = firing._lost_after_s(machine, ramp(520.0, 720.0), within_k=20.0)
    assert lost_s is not None
    assert later_s is not None
    assert later_s > lost_s


def test_ramps_up_are_looked_at_and_no_others(machine: Machine) -> None:
    programs = example("kiln").controller.programs
    assert programs is not None
    ways = [(way.from_k, way.to_k) for way in firing._ramps(machine, programs)]
    assert ways == [(0.0, 520.0), (520.0, 780.0)]


@pytest.mark.parametrize(
    ("steep", "form"), [("over: 12 min", "over: {} min"), ("at: 2600 K/h", "at: {} K/h")]
)
def test_the_advice_is_good(steep: str, form: str) -> None:
    with pytest.raises(SpecError) as caught:
        kiln(f"{{to: 540 °C, {steep}}}")
    (problem,) = caught.value.problems
    assert "W cannot follow" in problem.reason
    advised = re.search(r"Use at (?:least|most) ([0-9.]+) ", problem.remedy)
    assert advised is not None
    assert kiln(f"{{to: 540 °C, {form.format(advised[1])}}}")


def test_no_power_is_enough_for_the_last_degree(machine: Machine) -> None:
    highest_k = machine.plant.steady_k(machine.full_power_w)
    assert "more power" in firing._slower(machine, ramp(highest_k + 1.0, 3600.0))
