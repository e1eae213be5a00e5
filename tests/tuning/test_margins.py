"""Margins against closed forms, and against what really becomes unstable."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import first_order, second_order

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.margins import is_stable, margins
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.reduced import Reduced
from heatwright.sim.tuning.rules import TIGHT, lambda_rule, model_for, robust_simc, simc

BETWEEN = 2e-3
"""Relative distance of two of the frequencies that margins are interpolated between."""


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


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_lambda_has_the_margins_of_its_theory(ratio: float) -> None:
    """exp(−θs)/((λ + θ)s): gain margin π/2·(1 + λ/θ), phase margin 90° − 57.3°·θ/(λ + θ)."""
    period_s, late_s = 0.01, 2.0
    dead_s = late_s + period_s / 2
    gains = lambda_rule(Reduced(5.0, 200.0, 0.0, dead_s), 0.0, ratio * dead_s)
    found = margins(first_order(5.0, 200.0, late_s), gains, period_s)
    # Sampling counts as half a period of dead time: exact up to the square of their ratio.
    assert found.gain == pytest.approx(math.pi / 2 * (1 + ratio), rel=2 * BETWEEN)
    expected_deg = 90 - math.degrees(1 / (1 + ratio))
    assert found.phase_deg == pytest.approx(expected_deg, rel=2 * BETWEEN)
    delay_s = math.radians(expected_deg) * (1 + ratio) * dead_s
    assert found.delay_s == pytest.approx(delay_s, rel=0.005)


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
    second_order,
    gain=st.floats(0.1, 20),
    lag_s=st.floats(20, 500),
    second_s=st.floats(0.5, 15),
    late_s=st.floats(0.0, 10),
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
