"""Model reduction and rules against the examples of their author (Skogestad 2003)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.reduced import Reduced, reduce
from heatwright.sim.tuning.rules import lambda_rule, simc


def reduced(lags: list[float], leads: list[float], gain: float, order: int) -> Reduced:
    return reduce(gain=gain, lags_s=lags, leads_s=leads, late_s=0.0, period_s=0.0, order=order)


def test_example_1() -> None:
    """1/((s + 1)(0.2s + 1)): PI with Kc = 5.5, τI = 0.8."""
    model = reduced([1.0, 0.2], [], 1.0, 1)
    assert model == pytest.approx(Reduced(1.0, 1.1, 0.0, 0.1))
    assert simc(model, 0.0) == pytest.approx(Gains(5.5, 5.5 / 0.8, 0.0, 0.0))


def test_example_3() -> None:
    """2(15s + 1)/((20s + 1)(s + 1)(0.1s + 1)²): PI 2.33, 1.05; PID 6.67, 0.4, 0.15."""
    lags, leads = [20.0, 1.0, 0.1, 0.1], [15.0]
    first, second = reduced(lags, leads, 2.0, 1), reduced(lags, leads, 2.0, 2)
    assert first == pytest.approx(Reduced(1.5, 1.05, 0.0, 0.15))
    assert second == pytest.approx(Reduced(1.5, 1.0, 0.15, 0.05))
    assert simc(first, 0.0) == pytest.approx(Gains(2.3333, 2.3333 / 1.05, 0.0, 0.0), rel=1e-4)
    ki = 6.6667 / 0.4
    assert simc(second, 0.0) == pytest.approx(Gains(ki * 0.55, ki, ki * 0.06, 0.0), rel=1e-4)


@pytest.mark.parametrize(
    ("lead", "lag", "dead", "gain", "rest"),
    [
        (15.0, 10.0, 1.0, 1.5, []),  # T1
        (15.0, 1.0, 3.0, 5.0, []),  # T1a
        (2.0, 1.0, 3.0, 1.0, []),  # T1b
        (8.0, 10.0, 1.0, 0.8, []),  # T2
        (3.0, 10.0, 1.0, 0.5, [2.0]),  # T3: 5 of 10, and 5 − 3 is left
        (3.0, 4.0, 1.0, 1.0, [1.0]),  # T3 with a lag below five dead times
    ],
)
def test_rules_for_leads(
    lead: float, lag: float, dead: float, gain: float, rest: list[float]
) -> None:
    # A lead looks for a larger lag first: one that is above all others has only this.
    others = [1000.0] if lead < lag else []
    found = reduce(
        gain=1.0, lags_s=[lag, *others], leads_s=[lead], late_s=dead, period_s=0.0, order=2
    )
    assert found.gain == pytest.approx(gain)
    assert found.second_s == pytest.approx(rest[0] if rest else 0.0)
    assert found.dead_s == dead


def test_sampling_is_half_a_period_of_dead_time() -> None:
    found = reduce(gain=1.0, lags_s=[9.0], leads_s=[], late_s=2.0, period_s=1.0, order=1)
    assert found.dead_s == 2.5


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
