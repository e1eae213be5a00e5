"""The solver of the checks against textbook formulae and scipy; what they say of a machine."""

import math
import re
from itertools import islice, pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig.bad_specs import bases
from rig.firmware import changed, controller_of
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from heatwright.spec import Controller, SpecError, Stepper, ThermalNetwork
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.checks.programs import firing
from heatwright.spec.checks.programs.firing import Ramp
from heatwright.spec.physics.heat_flows import BEND
from heatwright.spec.physics.matrices import exponential, solve
from heatwright.spec.physics.network import Heated

EPSILON = np.finfo(float).eps


def heated(*running: str, **changes: object) -> Heated:
    """One node of 100 J/K behind 0.5 K/W: 50 s; a sensor with a lag of 10 s."""
    plant = {
        "kind": "thermal_network", "nodes": {"body": "100 J/K"},
        "links": ({"between": ("body", "ambient"), "resistance": "0.5 K/W"},),
        "heat": {"heater": "body"}, "sense": {"probe": {"node": "body", "lag": "10 s"}},
    }  # fmt: skip
    return Heated(ThermalNetwork.model_validate(plant | changes), "heater", "probe", 20.0, running)


@pytest.mark.parametrize("names", [("fan",), ("fan", "cooler")])
def test_each_fan_multiplies_the_conductance_that_the_others_leave(names: tuple[str, ...]) -> None:
    """A cooler may be on the link that a fan blows on always."""
    fans = {name: {"link": ("ambient", "body"), "factor": 4} for name in names}
    still, moved = heated(fans=fans), heated(*names, fans=fans)
    times = 4 ** len(names)
    assert still.steady_k(100) == pytest.approx(times * moved.steady_k(100), rel=4 * EPSILON)


def test_a_ramp_warms_all_and_makes_up_for_losses() -> None:
    """A sensor that lags by 10 s is behind by rate · 10 s."""
    assert heated().ramp_power_w(300.0, 0.2) == pytest.approx(100 * 0.2 + (300 + 2) / 0.5)
    assert heated().ramp_power_w(300.0, 0.0) == pytest.approx(heated().power_w(300.0))
    assert heated().answer_s() == pytest.approx(50 + 10)


def test_the_rise_is_that_of_two_lags() -> None:
    found, end, slow, quick = heated(), 50.0, 50.0, 10.0
    for time_s, state in islice(found.course(found.start(0), 100, 0.5, 8), 400):
        late = slow * math.exp(-time_s / slow) - quick * math.exp(-time_s / quick)
        expected = end * (1 - late / (slow - quick))
        # Every step rounds a few times; 400 of them, and squared matrices.
        assert found.sensed_k(state) == pytest.approx(expected, abs=end * 1e4 * EPSILON)


def test_steps_grow_to_the_longest() -> None:
    times = [time for time, _ in islice(heated().course(heated().start(0), 1, 0.5, 2.5), 300)]
    assert {later - sooner for sooner, later in pairwise(times)} == {0.5, 1.0, 2.0}


def test_a_swing_is_the_frequency_response() -> None:
    omega = 2 * math.pi / 20
    gain = 0.5 / math.hypot(1, omega * 50) / math.hypot(1, omega * 10)
    expected = 2 * 2 * 100 / math.pi * gain
    assert heated().swing_k(100, 20) == pytest.approx(expected, rel=16 * EPSILON)


GLOWING = {"between": ("body", "ambient"), "area": "0.02 m²", "emissivity": 0.8}
FACTOR = 5.670374419e-8 * 0.02 * 0.8


def test_two_surfaces_radiate_to_each_other() -> None:
    """P = σ·ε·A·(T⁴ − T₀⁴): without a link, all of the heat has to be radiated."""
    between = {"between": ("wire", "body"), "area": "0.02 m²", "emissivity": 0.8}

    def end_k(node: str) -> float:
        nodes, sense = {"wire": "10 J/K", "body": "100 J/K"}, {"probe": {"node": node}}
        parts = {"nodes": nodes, "heat": {"heater": "wire"}, "radiation": (between,)}
        found = heated(**parts, sense=sense)
        assert found.power_w(found.steady_k(200)) == pytest.approx(200, rel=1e-9)
        return found.steady_k(200)

    wire_k, body_k = end_k("wire"), end_k("body")
    assert body_k == pytest.approx(100, rel=1e-9)
    flow_w = FACTOR * ((wire_k + 293.15) ** 4 - (body_k + 293.15) ** 4)
    assert flow_w == pytest.approx(200, rel=1e-9)


@pytest.mark.parametrize("power_w", [0.0, 1500.0])
def test_a_course_with_radiation_is_that_of_its_equation(power_w: float) -> None:
    """Against scipy. The tangents miss up to 6·0.01² of T⁴ and less, all through 0.5 K/W."""
    found = heated(radiation=(GLOWING,), sense={"probe": {"node": "body"}})
    begin_k = 600.0 - power_w / 3
    course = list(islice(found.course(found.start(begin_k), power_w, 0.5, 4), 300))
    times = [time_s for time_s, _ in course]

    def slope(_: float, theta: np.ndarray) -> np.ndarray:
        radiated = FACTOR * ((theta + 293.15) ** 4 - 293.15**4)
        return np.asarray((power_w - theta / 0.5 - radiated) / 100.0)

    finely: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-8}
    exact = solve_ivp(slope, (0, times[-1]), [begin_k], t_eval=times, **finely)
    hottest = max(exact.y[0]) + 293.15
    allowed_k = 6 * BEND**2 * FACTOR * hottest**4 * 0.5
    off_k = [found.sensed_k(state) - y for (_, state), y in zip(course, exact.y[0], strict=True)]
    assert max(map(abs, off_k)) <= allowed_k
    at_once = found.advance(found.start(begin_k), power_w, times[-1])  # it is taken in parts
    assert found.sensed_k(at_once) == pytest.approx(exact.y[0][-1], abs=allowed_k)


def of_size(size: int, inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.lists(inner, min_size=size, max_size=size)


matrices = st.integers(1, 6).flatmap(lambda n: of_size(n, of_size(n, st.floats(-3, 3))))


@given(matrices)
def test_exponential(matrix: list[list[float]]) -> None:
    expected = expm(np.array(matrix))
    # Both are good to the norm of e^A times a few roundings per squaring.
    bound = 1e3 * EPSILON * np.exp(np.linalg.norm(matrix, np.inf))
    assert np.abs(np.array(exponential(matrix)) - expected).max() <= bound


@given(matrices, st.data())
def test_solve(matrix: list[list[float]], data: st.DataObject) -> None:
    size = len(matrix)
    # Diagonally dominant, as every network that loses heat to ambient is.
    dominant = [[v + 30 * (i == j) for j, v in enumerate(row)] for i, row in enumerate(matrix)]
    right = data.draw(of_size(size, st.floats(-100, 100)))
    found = np.array(solve(dominant, right))
    assert np.abs(np.array(dominant) @ found - right).max() <= 1e3 * EPSILON * 100


FIRST = "{to: 540 °C, over: 60 min}"


def machine_of(controller: Controller) -> Machine:
    name, loop = next(iter(controller.loops.items()))
    heater = controller.outputs[loop.heater]
    assert not isinstance(heater, Stepper)
    return Machine(controller, name, heater, controller.simulated)


def test_a_cooler_cools_faster() -> None:
    """At 320 °C the block alone falls by θ/(R·C); with the cooler by four times that. The sensor
    follows with its lag, so it never falls as fast as the block at the start."""
    alone_k_per_s = 300 / (8 * 27)
    course = machine_of(controller_of(bases()["simulated_fabricator"])).cooling()
    steepest = max(
        (before - after) / (after_s - before_s)
        for (before_s, before), (after_s, after) in pairwise(course)
    )
    assert alone_k_per_s < steepest < 4 * alone_k_per_s


def kiln(first: str = FIRST) -> Controller:
    return controller_of(changed(bases()["simulated_kiln"], (FIRST, first)))


def ramp(to_k: float, seconds: float) -> Ramp:
    return Ramp((), "over", 0.0, to_k, seconds)


@pytest.mark.parametrize(
    ("steep", "form"), [("over: 12 min", "over: {} min"), ("at: 2600 K/h", "at: {} K/h")]
)
def test_the_advice_is_good(steep: str, form: str) -> None:
    with pytest.raises(SpecError) as caught:
        kiln(f"{{to: 540 °C, {steep}}}")
    (problem,) = caught.value.problems
    assert "W are too little" in problem.reason
    advised = re.search(r"Use at (?:least|most) ([0-9.]+) ", problem.remedy)
    assert advised is not None
    assert kiln(f"{{to: 540 °C, {form.format(advised[1])}}}")


def test_no_power_is_enough_for_the_last_degree() -> None:
    machine = machine_of(kiln())
    highest_k = machine.plant.steady_k(machine.full_power_w)
    assert "more power" in firing._slower(machine, ramp(highest_k + 1.0, 3600.0))
