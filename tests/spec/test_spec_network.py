"""The small solver of the checks against textbook formulae and scipy's matrix exponential."""

import math
from itertools import islice, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from heatwright.spec import Controller, ThermalNetwork
from heatwright.spec.network import Heated, exponential, solve

EPSILON = np.finfo(float).eps


def network(**changes: object) -> ThermalNetwork:
    """One node of 100 J/K behind 0.5 K/W: 50 s; a sensor with a lag of 10 s."""
    return ThermalNetwork.model_validate(
        {
            "kind": "thermal_network",
            "nodes": {"body": "100 J/K"},
            "links": ({"between": ("body", "ambient"), "resistance": "0.5 K/W"},),
            "heat": {"heater": "body"},
            "sense": {"probe": {"node": "body", "lag": "10 s"}},
            **changes,
        }
    )


def test_the_end_is_ohms_law() -> None:
    assert Heated(network(), "heater", "probe").steady_k(100) == pytest.approx(50, rel=4 * EPSILON)


def test_a_fan_multiplies_the_conductance() -> None:
    fans = {"fan": {"link": ("ambient", "body"), "factor": 4}}
    still, moved = (
        Heated(network(fans=fans), "heater", "probe", running).steady_k(100)
        for running in ((), ("fan",))
    )
    assert still == pytest.approx(4 * moved, rel=4 * EPSILON)


def test_the_rise_is_that_of_two_lags() -> None:
    heated = Heated(network(), "heater", "probe")
    end, slow, quick = 50.0, 50.0, 10.0
    for time_s, state in islice(heated.course(heated.start(0), 100, 0.5, 8), 400):
        expected = end * (
            1
            - slow / (slow - quick) * math.exp(-time_s / slow)
            + quick / (slow - quick) * math.exp(-time_s / quick)
        )
        # Every step rounds a few times; 400 of them, and squared matrices.
        assert heated.sensed_k(state) == pytest.approx(expected, abs=end * 1e4 * EPSILON)


def test_steps_grow_to_the_longest() -> None:
    heated = Heated(network(), "heater", "probe")
    times = [time for time, _ in islice(heated.course(heated.start(0), 1, 0.5, 2.5), 300)]
    assert {later - sooner for sooner, later in pairwise(times)} == {0.5, 1.0, 2.0}


def test_cooling_starts_where_it_is() -> None:
    heated = Heated(network(), "heater", "probe")
    after = heated.advance(heated.start(30), 0, 50)
    assert after[0] == pytest.approx(30 / math.e, rel=1e3 * EPSILON)


def test_a_swing_is_the_frequency_response() -> None:
    omega = 2 * math.pi / 20
    gain = 0.5 / math.hypot(1, omega * 50) / math.hypot(1, omega * 10)
    swing = Heated(network(), "heater", "probe").swing_k(100, 20)
    assert swing == pytest.approx(2 * 2 * 100 / math.pi * gain, rel=16 * EPSILON)


def test_the_chambers_losses(chamber: Controller) -> None:
    """The published wall is 0.281 K/W from air to ambient, here 0.303 with what is around it."""
    assert chamber.simulation is not None
    heated = Heated(chamber.simulation.plant, "heater", "air")
    assert heated.steady_k(240) == pytest.approx(240 * (0.173 + 0.130), rel=16 * EPSILON)


matrices = st.integers(1, 6).flatmap(
    lambda size: st.lists(
        st.lists(st.floats(-3, 3), min_size=size, max_size=size), min_size=size, max_size=size
    )
)


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
    right = data.draw(st.lists(st.floats(-100, 100), min_size=size, max_size=size))
    found = np.array(solve(dominant, right))
    assert np.abs(np.array(dominant) @ found - right).max() <= 1e3 * EPSILON * 100
