"""The answer by modes is the plant's own, to rounding."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from known_machines import POWER_W, Series, machine, recorded, steps

from heatwright.sim.identify import Record
from heatwright.sim.identify.answer import APART, LEAST_LAG_S, WORST_CONDITION, Answer, modes
from heatwright.spec import ThermalNetwork

EPS = float(np.finfo(float).eps)


def exact(record: Record) -> float:
    """What rounding may do along eigenvectors of the worst condition, and the least lag, K."""
    steepest = float(np.abs(np.diff(record.readings_c)).max(initial=0.0)) / float(record.times_s[1])
    return WORST_CONDITION * EPS * (20 + float(np.ptp(record.readings_c))) + LEAST_LAG_S * steepest


def answered(
    network: ThermalNetwork, record: Record, delay_s: float, start_c: Series | None = None
) -> Series:
    found = modes(network, "heater", "sensor")
    return Answer(record, 0.0).readings(found, delay_s, 20.0, start_c)


MACHINES = st.builds(
    machine, st.integers(1, 5000), st.integers(1, 50), st.integers(0, 200), st.integers(0, 20)
)


@given(network=MACHINES, duty=st.lists(st.floats(0, 1), min_size=2, max_size=60))
@example(network=machine(10.0, 2.0, 3.0, 4.0, case=(50.0, 1.0)), duty=steps().tolist())
def test_it_answers_as_the_plant(network: ThermalNetwork, duty: list[float]) -> None:
    record = recorded(network, duty)
    found = answered(network, record, network.sense["sensor"].delay_s)
    assert found == pytest.approx(record.readings_c, rel=0, abs=exact(record))


@pytest.mark.parametrize("lag", [16.7 * 14.7, 16.7 * 14.7 * (1 + 1e-9)])
def test_equal_time_constants_have_no_modes_but_an_answer(lag: float) -> None:
    network = machine(lag=lag)
    record = recorded(network, steps())
    moved_k = float(np.ptp(record.readings_c))
    # A relative change of a time constant moves no step response by more than its share.
    found = answered(network, record, 1.3)
    assert found == pytest.approx(record.readings_c, rel=0, abs=8 * APART * moved_k + exact(record))


def test_a_fraction_of_a_row_of_dead_time_counts() -> None:
    network = machine(delay=0.0, lag=0.0)
    record = recorded(network, steps(100, (10, 1.0)))
    late = answered(network, record, 0.5)
    time_s = 89 - 0.5
    rise_k = 14.7 * POWER_W * (1 - np.exp(-time_s / (16.7 * 14.7)))
    assert late[99] == pytest.approx(20 + rise_k, rel=0, abs=exact(record))


def test_a_start_that_is_not_at_rest_dies_away() -> None:
    network = machine(lag=0.0, delay=0.0)
    record = recorded(network, np.zeros(500))
    found = answered(network, record, 0.0, np.array([100.0, 100.0]))
    expected = 20 + 80 * np.exp(-record.times_s / (16.7 * 14.7))
    assert found == pytest.approx(expected, rel=0, abs=100 * WORST_CONDITION * EPS)
