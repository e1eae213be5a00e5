"""Resistance of sensing elements over temperature, for arrays: °C in, Ω out."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from heatwright.spec import BetaCurve, CodesCurve, PointsCurve, Rtd, Thermistor

Array = NDArray[np.float64]

ZERO_C = 273.15
"""0 °C in K."""


def element_ohm(sensor: Thermistor | Rtd, celsius: Array) -> Array:
    """Return the sensing element's resistance."""
    if sensor.curve is None:
        return platinum_ohm(sensor, celsius)
    return thermistor_ohm(sensor, celsius)


def thermistor_ohm(sensor: Thermistor, celsius: Array) -> Array:
    """Return a thermistor's resistance, by the kind of curve in its spec."""
    kelvin = celsius + ZERO_C
    curve = sensor.curve
    if isinstance(curve, BetaCurve):
        return beta_ohm(kelvin, curve.resistance_ohm, curve.at_c + ZERO_C, curve.beta_k)
    if isinstance(curve, PointsCurve):
        return interpolated_ohm(kelvin, curve.points)
    if isinstance(curve, CodesCurve):
        return coded_ohm(sensor, celsius)
    return steinhart_hart_ohm(kelvin, curve.a, curve.b, curve.c)


def beta_ohm(kelvin: Array, nominal_ohm: float, nominal_k: float, beta_k: float) -> Array:
    """Return R = R₀·e^(β(1/T − 1/T₀)), the Arrhenius law of a semiconductor."""
    law: Array = nominal_ohm * np.exp(beta_k * (1 / kelvin - 1 / nominal_k))
    return law


def steinhart_hart_ohm(kelvin: Array, a: float, b: float, c: float) -> Array:
    """Return the resistance whose logarithm x solves c·x³ + b·x + (a − 1/T) = 0.

    The one real root of a depressed cubic x³ + p·x + q with p > 0 by the hyperbolic sine:
    x = −2·√(p/3)·sinh(⅓·arsinh(3q/(2p)·√(3/p))), from sinh 3u = 3 sinh u + 4 sinh³ u.
    """
    if c == 0:
        return np.asarray(np.exp((1 / kelvin - a) / b))
    p, q = b / c, (a - 1 / kelvin) / c
    angle = np.arcsinh(1.5 * q / p * np.sqrt(3 / p)) / 3
    return np.asarray(np.exp(-2 * np.sqrt(p / 3) * np.sinh(angle)))


def interpolated_ohm(kelvin: Array, points: tuple[tuple[float, float], ...]) -> Array:
    """Return R: ln R is linear in 1/T between points, and the end pieces extend beyond them.

    points -- pairs of temperature, °C, and resistance, Ω.
    """
    inverse, logs, slope = _pieces(points)
    wanted = 1 / kelvin
    piece = inverse[1:-1].searchsorted(wanted)
    return np.exp(logs[piece] + slope[piece] * (wanted - inverse[piece]))


SUPPLY_V = 5.0
"""Supply of the board."""


def coded_ohm(sensor: Thermistor, celsius: Array) -> Array:
    """Return the resistance with which the divider gives the codes of a table.

    A code of several readings is the middle of its step, (code / readings + 1/2) / 1024 of the
    reference; between pairs the voltage is linear in T, beyond them ln R is linear in 1/T.
    """
    assert isinstance(sensor.curve, CodesCurve)  # noqa: S101 - the caller has checked
    full_v = sensor.reference if isinstance(sensor.reference, float) else SUPPLY_V
    at_c, volts = _coded(sensor.curve.codes, sensor.curve.readings, full_v)
    inside = _element_ohm(sensor, np.interp(celsius, at_c, volts))
    if np.min(celsius) >= at_c[0] and np.max(celsius) <= at_c[-1]:
        return inside
    points = tuple(zip(at_c.tolist(), _element_ohm(sensor, volts).tolist(), strict=True))
    cold, hot = (interpolated_ohm(celsius + ZERO_C, each) for each in (points[:2], points[-2:]))
    return np.where(celsius < at_c[0], cold, np.where(celsius > at_c[-1], hot, inside))


@lru_cache(maxsize=16)
def _coded(
    codes: tuple[tuple[int, float], ...], readings: int, full_v: float
) -> tuple[Array, Array]:
    """Return a table's temperatures, ascending, with the pin's volts."""
    sums, at_c = np.array(sorted(codes, key=lambda pair: pair[1])).T
    return at_c, (sums / readings + 0.5) / 1024 * full_v


def _element_ohm(sensor: Thermistor, volts: Array) -> Array:
    """Return the element's resistance in a divider with this voltage at its middle."""
    divider = sensor.divider
    supply_v = SUPPLY_V if divider.supply_v is None else divider.supply_v
    if divider.pull_up_ohm is not None:
        return volts / ((supply_v - volts) / divider.pull_up_ohm)
    return (supply_v - volts) / (volts / (divider.pull_down_ohm or np.nan))


@lru_cache(maxsize=16)
def _pieces(points: tuple[tuple[float, float], ...]) -> tuple[Array, Array, Array]:
    """Return 1/T and ln R at the ends of the straight pieces, and the slopes of the pieces."""
    at_c, ohms = np.array(points).T
    inverse = 1 / (at_c + ZERO_C)
    order = np.argsort(inverse)
    inverse, logs = inverse[order], np.log(ohms[order])
    return inverse, logs, np.diff(logs) / np.diff(inverse)


def platinum_ohm(sensor: Rtd, celsius: Array) -> Array:
    """Return a platinum sensor's resistance: linear by its alpha, or by Callendar–Van Dusen."""
    zero_ohm = {"pt100": 100.0, "pt1000": 1000.0}[sensor.element]
    if sensor.alpha_ppm_per_k is not None:
        return zero_ohm + zero_ohm * sensor.alpha_ppm_per_k / 1e6 * celsius
    cubic = -4.183e-12 * (celsius - 100) * np.minimum(celsius, 0.0)
    return zero_ohm * (1 + celsius * (3.9083e-3 + celsius * (-5.775e-7 + cubic)))
