"""Tuning against closed forms, its sources, and what really becomes unstable."""

import math
from dataclasses import replace
from functools import partial
from itertools import islice

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rig.firmware import example

from heatwright.cli.ends import Refused
from heatwright.cli.tune.task import task_of
from heatwright.sim.reference.algorithms.pid import PidControl
from heatwright.sim.reference.numbers import Single
from heatwright.sim.tuning.disturbed import LOAD_PERCENT, load_answer, step_kick
from heatwright.sim.tuning.gains import Gains, Series
from heatwright.sim.tuning.loop import minimal_pid, pid, sampled, sampled_response
from heatwright.sim.tuning.margins import is_stable, margins
from heatwright.sim.tuning.process import Process, at_full_power, process_of
from heatwright.sim.tuning.reduced import Reduced, reduce
from heatwright.sim.tuning.rules import TIGHT, lambda_rule, model_for, robust_simc, simc
from heatwright.sim.tuning.trial import at_setpoint
from heatwright.spec import Pid


def first_order(gain: float, lag_s: float, late_s: float = 0.0) -> Process:
    """gain·exp(−late·s)/(lag·s + 1)."""
    return Process(np.array([[-1 / lag_s]]), np.array([gain / lag_s]), np.array([1.0]), late_s)


def second_order(gain: float, lag_s: float, second_s: float, late_s: float = 0.0) -> Process:
    """gain·exp(−late·s)/((lag·s + 1)(second·s + 1))."""
    matrix = np.array([[-1 / lag_s, 0.0], [1 / second_s, -1 / second_s]])
    return Process(matrix, np.array([gain / lag_s, 0.0]), np.array([0.0, 1.0]), late_s)


BETWEEN = 2e-3  # relative distance of two of the frequencies that margins are interpolated between


def proportional(kp: float) -> Gains:
    return Gains(kp, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("kp", [0.5, 3.0, 7.0])
def test_proportional_control_of_one_lag(kp: float) -> None:
    """L = g/(z − p): gain margin at z = −1, crossover where |z − p| = g."""
    gain, lag_s, period_s = 5.0, 20.0, 1.0
    pole = math.exp(-period_s / lag_s)
    g = kp * gain * (1 - pole)
    found = margins(first_order(gain, lag_s), proportional(kp), period_s)
    assert found.gain == pytest.approx((1 + pole) / g, rel=BETWEEN)
    angle = math.acos((1 + pole**2 - g**2) / (2 * pole))
    z = complex(math.cos(angle), math.sin(angle))
    phase = math.pi - math.atan2(z.imag, z.real - pole)
    assert found.crossover == pytest.approx(angle / period_s, rel=BETWEEN)
    assert found.phase_deg == pytest.approx(math.degrees(phase), rel=BETWEEN)
    assert found.delay_s == pytest.approx(phase / angle * period_s, rel=2 * BETWEEN)
    around = np.exp(1j * np.linspace(1e-6, math.pi, 200_001))
    nearest = np.abs(1 + g / (around - pole)).min()
    assert found.sensitivity == pytest.approx(1 / nearest, rel=BETWEEN)


def test_a_loop_that_never_reaches_one_and_one_that_is_unstable() -> None:
    found = margins(first_order(1.0, 20.0), proportional(0.5), 1.0)
    assert (found.crossover, found.phase_deg, found.delay_s) == (0.0, math.inf, math.inf)
    assert found.stable
    unstable = margins(first_order(5.0, 20.0, 5.0), proportional(10.0), 1.0)
    assert not unstable.stable
    assert unstable.gain < 1


@pytest.mark.parametrize(
    ("lag_s", "gain", "phase_deg", "sensitivity"),
    [(8.0, 3.14, 61.4, 1.59), (20_000.0, 2.96, 46.9, 1.70)],
    ids=["a lag", "integrating"],
)
def test_simc_has_the_margins_its_author_gives(
    lag_s: float, gain: float, phase_deg: float, sensitivity: float
) -> None:
    """Skogestad 2003, table 2: first order with dead time, tight."""
    dead_s, period_s, slope = 2.0, 0.01, 0.25
    gains = simc(Reduced(slope * lag_s, lag_s, 0.0, dead_s), 0.0)
    process = first_order(slope * lag_s, lag_s, dead_s - period_s / 2)
    found = margins(process, gains, period_s)
    assert found.gain == pytest.approx(gain, abs=0.01)
    assert found.phase_deg == pytest.approx(phase_deg, abs=0.1)
    assert found.sensitivity == pytest.approx(sensitivity, abs=0.01)


def scaled(gains: Gains, factor: float) -> Gains:
    return gains._replace(kp=gains.kp * factor, ki=gains.ki * factor, kd=gains.kd * factor)


processes = st.builds(
    second_order, st.floats(0.1, 20), st.floats(20, 500), st.floats(0.5, 15), st.floats(0, 10)
)


@settings(max_examples=40)
@given(process=processes, period_s=st.sampled_from([0.1, 1.0]), filter_s=st.floats(0.2, 4.0))
def test_the_loop_oscillates_just_beyond_its_margins(
    process: Process, period_s: float, filter_s: float
) -> None:
    """Poles of the closed loop, which know nothing of frequencies, judge the margins."""
    lag_s, second_s = process.lags_s
    dead_s = process.late_s + period_s / 2 + filter_s
    gains = simc(Reduced(process.gain, lag_s, second_s, dead_s), filter_s)
    found = margins(process, gains, period_s)
    assert found.stable
    assert is_stable(process, scaled(gains, found.gain * (1 - BETWEEN)), period_s)
    assert not is_stable(process, scaled(gains, found.gain * (1 + BETWEEN)), period_s)
    # Dead time of whole periods is a pure delay of the sampled loop.
    periods = found.delay_s / period_s
    for whole, stays in ((math.floor(periods), True), (math.ceil(periods), False)):
        if abs(whole - periods) > 2 * BETWEEN * periods:
            later = replace(process, late_s=process.late_s + whole * period_s)
            assert is_stable(later, gains, period_s) is stays


@pytest.mark.parametrize(("second_s", "late_s"), [(4.5, 0.1), (15.0, 0.1), (1.0, 5.0)])
def test_simc_is_made_slower_until_it_is_as_robust_as_it_promises(
    second_s: float, late_s: float
) -> None:
    process, period_s, filter_s = second_order(6.0, 250.0, second_s, late_s), 0.1, 1.0
    model = model_for(process, period_s, filter_s)
    found = margins(process, robust_simc(process, model, filter_s, period_s), period_s)
    assert found.stable
    assert found.sensitivity <= TIGHT
    tight = margins(process, simc(model, filter_s), period_s)
    if tight.sensitivity > TIGHT:
        # The search ends within 1/64 of the time constant, and Ms follows that in proportion.
        assert found.sensitivity == pytest.approx(TIGHT, rel=1 / 64)
    else:
        assert found == tight


# ---- the sampled process and the PID, also against the reference model ----

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
    assert (load.dip_k, load.half_s) == (pytest.approx(ends_k, rel=1e-3), None)
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


# ---- model reduction and rules against the examples of their author (Skogestad 2003) ----


reduced = partial(reduce, gain=1.0, leads_s=[], late_s=0.0, period_s=0.0)


def test_example_3() -> None:
    """2(15s + 1)/((20s + 1)(s + 1)(0.1s + 1)²): PI 2.33, 1.05; PID 6.67, 0.4, 0.15."""
    model = {"lags_s": [20.0, 1.0, 0.1, 0.1], "leads_s": [15.0], "gain": 2.0}
    first, second = (reduced(**model, order=order) for order in (1, 2))
    assert first == pytest.approx(Reduced(1.5, 1.05, 0.0, 0.15))
    assert second == pytest.approx(Reduced(1.5, 1.0, 0.15, 0.05))
    assert simc(first, 0.0)[:4] == pytest.approx((2.3333, 2.3333 / 1.05, 0.0, 0.0), rel=1e-4)
    ki = 6.6667 / 0.4
    assert simc(second, 0.0)[:4] == pytest.approx((ki * 0.55, ki, ki * 0.06, 0.0), rel=1e-4)


@pytest.mark.parametrize(
    ("lead", "lag", "dead", "gain", "rest"),
    [
        (15.0, 10.0, 1.0, 1.5, 0), (15.0, 1.0, 3.0, 5.0, 0), (2.0, 1.0, 3.0, 1.0, 0),  # T1, a, b
        (8.0, 10.0, 1.0, 0.8, 0),  # T2
        (3.0, 10.0, 1.0, 0.5, 2.0),  # T3: 5 of 10, and 5 − 3 is left
        (3.0, 4.0, 1.0, 1.0, 1.0),  # T3 with a lag below five dead times
    ],
)  # fmt: skip
def test_rules_for_leads(lead: float, lag: float, dead: float, gain: float, rest: float) -> None:
    # A lead looks for a larger lag first: one that is above all others has only this.
    others = [1000.0] if lead < lag else []
    found = reduced(lags_s=[lag, *others], leads_s=[lead], late_s=dead, order=2)
    assert (found.gain, found.second_s) == (pytest.approx(gain), pytest.approx(rest))
    assert found.dead_s == dead


def test_sampling_is_half_a_period_of_dead_time() -> None:
    assert reduced(lags_s=[9.0], late_s=2.0, period_s=1.0, order=1).dead_s == 2.5


def test_a_double_integrator_is_not_cancelled_but_led() -> None:
    """Skogestad, table 1: k″/s² with Kc = 1/(k″·4(τc+θ)²), τI = τD = 4(τc+θ)."""
    gains = simc(Reduced(1e6, 1e3, 1e3, 1.0), 0.0)
    kc = 1 / (1.0 * 4 * 2.0**2)
    assert gains == pytest.approx(Gains(2 * kc, kc / 8, kc * 8, 0.0))


@given(closed_s=st.floats(0.5, 100))
def test_what_is_asked_for_sets_the_speed(closed_s: float) -> None:
    model = Reduced(2.0, 50.0, 0.0, 1.0)
    for rule in (simc, lambda_rule):
        assert rule(model, 0.0, closed_s).kp == pytest.approx(25 / (closed_s + 1))
    assert lambda_rule(model, 0.0, closed_s).ki == pytest.approx(0.5 / (closed_s + 1))


LOOP = "chamber"


def task(spec, at_c=None):
    (loop,) = spec.controller.loops
    return task_of(spec, loop, at_c=at_c, lambda_s=None, tauc_s=None)


def test_a_linear_machine_ends_where_its_gain_says(chamber):
    process = process_of(chamber, "air")
    step_s = process.lags_s[0]
    (*_, (time_s, ends_c)) = islice(at_full_power(chamber, "air", step_s), 40)
    assert time_s == pytest.approx(40 * step_s)
    assert ends_c == pytest.approx(chamber.simulation.ambient_c + 100 * process.gain)


def test_a_kiln_ends_where_it_radiates_what_it_is_given():
    """Each kelvin of the brick takes a part of the element's power, and its fourth power one."""
    kiln = example("kiln").controller
    (*_, (_, ends_c)) = islice(at_full_power(kiln, LOOP, 200.0), 400)
    brick_k = ends_c - 484 * 0.5 + 273.15
    lost_w = (brick_k - 293.15) / 2.6 + 5.670374419e-8 * 0.005 * 0.3 * (brick_k**4 - 293.15**4)
    assert lost_w == pytest.approx(484, rel=1e-6)


def test_it_is_tuned_for_the_hottest_of_its_programs():
    found = task(example("kiln"))
    assert found.target_c == 800.0
    assert 600 < found.warm_s < 3600


def test_what_full_power_does_not_reach_is_refused():
    spec = example("kiln_uno")
    outputs = dict(spec.controller.outputs)
    outputs["element"] = outputs["element"].model_copy(update={"power_w": 100.0})
    weak = spec.controller.model_copy(update={"outputs": outputs})
    with pytest.raises(Refused, match="full power ends at"):
        task(spec._replace(controller=weak), at_c=600.0)


def test_what_people_switch_is_on_from_the_start():
    kiln = at_setpoint(example("kiln").controller, LOOP, 500.0).loops[LOOP]
    assert (kiln.starts, kiln.setpoint.initial_c) == ("enabled", 500.0)
    for name, loop in (("extruder", "nozzle"), ("fabricator", "nozzle")):
        controller = example(name).controller
        assert at_setpoint(controller, loop, 100.0) is controller
