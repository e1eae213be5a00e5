"""The sampled process and the PID against closed forms, and against the reference model."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from processes import first_order

from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.pid import PidControl
from heatwright.sim.tuning.disturbed import LOAD_PERCENT, load_answer, step_kick
from heatwright.sim.tuning.gains import Gains, Series
from heatwright.sim.tuning.loop import minimal_pid, pid, pid_response, sampled, sampled_response
from heatwright.spec import Pid

GAIN, LAG_S, PERIOD_S = 5.0, 200.0, 1.0
Z = np.exp(1j * np.geomspace(1e-4, math.pi, 50))


@given(late=st.integers(0, 50), part=st.sampled_from([0.0, 0.25, 0.5, 0.999]))
def test_a_sampled_lag_with_dead_time(late: int, part: float) -> None:
    """Åström & Wittenmark, Computer-Controlled Systems, example 3.5."""
    found = np.array([sampled(first_order(GAIN, LAG_S, late + part), PERIOD_S)(z) for z in Z])
    pole = math.exp(-PERIOD_S / LAG_S)
    now = GAIN * (1 - math.exp(-(PERIOD_S - part) / LAG_S))
    before = GAIN * (math.exp(-(PERIOD_S - part) / LAG_S) - pole)
    quick = sampled_response(first_order(GAIN, LAG_S, late + part), PERIOD_S, Z)
    expected = Z ** (-late - 1.0) * (now + before / Z) / (1 - pole / Z)
    assert found == pytest.approx(expected, rel=1e-9)
    assert quick == pytest.approx(expected, rel=1e-9)


GAINS = Gains(3.0, 0.05, 40.0, 4.0)


def reference(**more: object) -> PidControl:
    """The reference's controller with the same gains."""
    gains = {"kp": 3.0, "ki": 0.05, "kd": 40.0, "derivative_filter": "4 s"}
    return PidControl(Pid.model_validate({"kind": "pid", **gains, **more}), PERIOD_S)


def duty(pid: PidControl, celsius: float) -> float:
    return float(pid.step(Single(celsius), Single(0), 1, Single(50.0)))


def test_the_pid_is_the_references() -> None:
    its = reference(integral={"minimum": "50 %"})
    # An integral that begins at 50 % and small errors about 0: nothing is limited.
    random = np.random.default_rng(0)
    errors = np.concatenate(([0.0], np.abs(random.normal(0, 0.5, 200))))
    duties = [duty(its, 50.0 - error) for error in errors]
    assert 0 < min(duties) < max(duties) < 100
    linear = 50 + control.forced_response(pid(GAINS, PERIOD_S), U=errors).outputs
    # Each of some ten operations in single precision rounds numbers below 100.
    assert linear == pytest.approx(duties, rel=0, abs=10 * 100 * float(np.finfo(np.float32).eps))


def test_the_pids_response_is_its_systems() -> None:
    system = pid(GAINS, PERIOD_S)
    expected = np.array([system(z) for z in Z])
    assert pid_response(GAINS, PERIOD_S, Z) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("ki", "kd", "states"), [(0.0, 0.0, 0), (0.1, 0.0, 1), (0.1, 5.0, 2)])
def test_terms_that_are_off_have_no_states(ki: float, kd: float, states: int) -> None:
    assert minimal_pid(Gains(1.0, ki, kd, 3.0), 1.0).nstates == states


@given(integral=st.floats(2, 500), derivative=st.floats(1.01, 100), filter_s=st.floats(0.01, 1.0))
def test_series_form_becomes_the_same_in_parallel(
    integral: float, derivative: float, filter_s: float
) -> None:
    gains = Series(2.0, integral, derivative).parallel(filter_s)
    for omega in (1e-3, 0.1, 3.0):
        s = 1j * omega
        series = 2 * (1 + 1 / (integral * s)) * (1 + derivative * s) / (1 + filter_s * s)
        parallel = gains.kp + gains.ki / s + gains.kd * s / (1 + filter_s * s)
        assert parallel == pytest.approx(series, rel=1e-9)
    assert min(gains[:3]) >= 0


def test_a_short_derivative_behind_a_long_filter_is_left_out() -> None:
    assert Series(2.0, 10.0, 1.0).parallel(1.0) == Gains(2.0, 0.2, 0.0, 1.0)


def test_a_load_under_proportional_control_stays_and_under_integral_goes_away() -> None:
    ends_k = GAIN * LOAD_PERCENT / (1 + GAIN * 3.0)
    load = load_answer(first_order(GAIN, LAG_S), Gains(3.0, 0.0, 0.0, 0.0), PERIOD_S)
    assert load.dip_k == pytest.approx(ends_k, rel=1e-3)
    assert load.half_s is None
    load = load_answer(first_order(GAIN, LAG_S, 2.0), Gains(3.0, 0.05, 0.0, 0.0), PERIOD_S)
    assert load.dip_k < ends_k
    assert load.half_s is not None
    assert load.half_s > load.after_s


def test_a_step_of_the_sensor_moves_all_terms() -> None:
    its = reference()
    *_, before = (duty(its, 49.0) for _ in range(3))
    kick = step_kick(GAINS, 0.25, PERIOD_S)
    # The integral also adds what it would have added anyway: ki times the old error.
    assert duty(its, 48.75) - before == pytest.approx(kick + 0.05 * 1.0, rel=1e-5)
