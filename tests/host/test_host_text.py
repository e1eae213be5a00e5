"""Numbers as text: inside their buffer and rounded half away from zero."""

import pytest
from host_text import EXTREMES, MOST_DECIMALS, code_problem, text_problem
from hypothesis import given
from hypothesis import strategies as st

DECIMALS = range(MOST_DECIMALS + 1)


@pytest.fixture(scope="module")
def host(hosts):
    return hosts("switch_lead")


@pytest.mark.parametrize("decimals", DECIMALS)
def test_extremes(host, decimals):
    assert [text_problem(host, value, decimals) for value in EXTREMES] == [""] * len(EXTREMES)


@given(value=st.floats(width=32), decimals=st.sampled_from(DECIMALS))
def test_any_number(host, value, decimals):
    assert text_problem(host, value, decimals) == ""


@given(value=st.floats(-2e7, 2e7, width=32), decimals=st.sampled_from(DECIMALS))
def test_numbers_within_the_range(host, value, decimals):
    assert text_problem(host, value, decimals) == ""


@pytest.mark.parametrize("decimals", DECIMALS)
def test_every_temperature_of_the_sensor_exactly(host, decimals):
    for raw in range(-(2**15), 2**15):
        assert code_problem(host, raw, decimals) == ""


def test_beyond_the_range_is_written_as_its_end(host):
    assert host.number(float("nan"), 2) == "20000000.00"
    assert host.number(float("-inf"), 2) == "-20000000.00"
    assert host.number(-3e38, 0) == "-20000000"
