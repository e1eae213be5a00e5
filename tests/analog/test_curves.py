"""Sensing elements: the standard's own numbers, and two ways to compute each agree."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.sim.circuits.elements import ZERO_C, beta_ohm, interpolated_ohm, steinhart_hart_ohm
from heatwright.spec.curves import Beta, Platinum, Points, SteinhartHart

IEC_60751 = {
    -200: 18.52, -100: 60.26, -50: 80.31, 0: 100.0, 25: 109.73, 100: 138.51, 200: 175.86,
    250: 194.10, 400: 247.09, 600: 313.71, 850: 390.48,
}  # fmt: skip
"""Resistance of a Pt100 by temperature, the standard's table: rounded to 0.01 Ω."""

AGREE = 1e-12
"""Relative; both ways are in double precision, with few operations of 1.1e-16 each."""

hot_c = st.floats(-50, 300)


@pytest.mark.parametrize("celsius", IEC_60751)
def test_platinum_is_that_of_the_standard(celsius: int) -> None:
    assert Platinum(100.0).ohm(celsius) == pytest.approx(IEC_60751[celsius], abs=0.005)
    assert Platinum(1000.0).ohm(celsius) == pytest.approx(10 * IEC_60751[celsius], abs=0.05)


@given(st.floats(-200, 850))
def test_platinum_and_back(celsius: float) -> None:
    curve = Platinum(100.0)
    assert curve.celsius(curve.ohm(celsius)) == pytest.approx(celsius, abs=1e-9)


@given(hot_c, st.floats(1, 1e6), st.floats(2000, 6000))
def test_beta_both_ways(celsius: float, nominal_ohm: float, beta_k: float) -> None:
    curve = Beta(nominal_ohm, 25.0, beta_k)
    ohm = curve.ohm(celsius)
    other = beta_ohm(np.array(celsius + ZERO_C), nominal_ohm, 25 + ZERO_C, beta_k)
    assert ohm == pytest.approx(float(other), rel=AGREE)
    assert curve.celsius(ohm) == pytest.approx(celsius, abs=1e-9)
    assert curve.ohm(25.0) == nominal_ohm


@given(hot_c, st.floats(1e-4, 2e-3), st.floats(1e-4, 4e-4), st.floats(1e-9, 5e-7))
def test_steinhart_hart_both_ways(celsius: float, a: float, b: float, c: float) -> None:
    curve = SteinhartHart(a, b, c)
    wanted = 1 / (celsius + ZERO_C)
    log = math.log(curve.ohm(celsius))
    assert a + b * log + c * log**3 == pytest.approx(wanted, rel=AGREE)
    other = math.log(float(steinhart_hart_ohm(np.array(celsius + ZERO_C), a, b, c)))
    assert log == pytest.approx(other, abs=1e-10)
    assert curve.celsius(curve.ohm(celsius)) == pytest.approx(celsius, abs=1e-9)


def test_a_thermistor_by_its_makers_three_numbers() -> None:
    """YSI 44006, 10 kΩ at 25 °C, with the coefficients its maker publishes."""
    curve = SteinhartHart(1.032e-3, 2.387e-4, 1.580e-7)
    assert curve.ohm(25.0) == pytest.approx(10e3, rel=0.002)


POINTS = ((0.0, 327e3), (25.0, 100e3), (100.0, 6.7e3), (200.0, 560.0), (300.0, 115.0))
RISING = ((0.0, 815.0), (25.0, 1000.0), (100.0, 1696.0), (150.0, 2260.0))


@given(hot_c, st.sampled_from((POINTS, RISING)))
def test_points_both_ways(celsius: float, points: tuple[tuple[float, float], ...]) -> None:
    curve = Points(points)
    ohm = curve.ohm(celsius)
    at_c, ohms = np.array(points).T
    other = interpolated_ohm(np.array(celsius + ZERO_C), at_c + ZERO_C, ohms)
    assert ohm == pytest.approx(float(other), rel=1e-11)
    assert curve.celsius(ohm) == pytest.approx(celsius, abs=1e-9)
    for point_c, point_ohm in points:
        assert curve.ohm(point_c) == pytest.approx(point_ohm, rel=AGREE)


@given(st.floats(0, 300))
def test_points_of_a_beta_are_that_beta(celsius: float) -> None:
    """Between two points the logarithm is straight over 1/T, which is what beta says."""
    beta = Beta(100e3, 25.0, 4267)
    points = Points(tuple((float(at_c), beta.ohm(at_c)) for at_c in (0, 40, 120, 300)))
    assert points.ohm(celsius) == pytest.approx(beta.ohm(celsius), rel=1e-11)
