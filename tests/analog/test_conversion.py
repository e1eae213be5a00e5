"""The firmware's tables: as exact as they say, and no table with fewer points is."""

from bisect import bisect_left
from itertools import pairwise

import numpy as np
import pytest
from rig.analog_specs import CIRCUITS, sensor
from scipy.optimize import linprog

from heatwright.sim.circuits import Wiring, pin_v, reference_v, shares
from heatwright.sim.reference.adc import converter
from heatwright.spec import BOARDS
from heatwright.spec.circuits import circuit
from heatwright.spec.conversion import CODES, conversion, limits

UNO = BOARDS["uno"]

every_circuit = pytest.mark.parametrize("name", CIRCUITS)


@every_circuit
def test_every_sum_is_within_half_a_step_of_the_exact_curve(name: str) -> None:
    part = sensor(name)
    bounds = limits(part, UNO.mcu)
    raw = np.arange(part.oversample * bounds.low, part.oversample * bounds.high + 1)
    law = converter(part, UNO)
    celsius = np.array([law(int(each)) for each in raw], float)
    error = np.abs(CODES * shares(part, UNO, celsius) - (raw / part.oversample + 0.5))
    assert error.max() < 0.5


@every_circuit
def test_no_table_of_fewer_points_would_be(name: str) -> None:
    """Straight pieces that need not even meet, each as long as can be, are no fewer."""
    part = sensor(name)
    bounds, chain = limits(part, UNO.mcu), circuit(part, UNO.mcu)
    edges = [chain.celsius(code / CODES) for code in range(bounds.low, bounds.high + 2)]
    lows = [min(pair) for pair in pairwise(edges)]
    highs = [max(pair) for pair in pairwise(edges)]
    pieces, start, last = 0, 0, len(lows) - 1
    while start < last:
        start = furthest(lows, highs, start)
        pieces += 1
    assert len(conversion(part, UNO.mcu).points) == pieces + 1


def furthest(lows: list[float], highs: list[float], start: int) -> int:
    """The last code that one straight line from code `start` can include."""
    ends = range(start + 1, len(lows))
    return start + bisect_left(ends, 1, key=lambda end: not is_straight(lows, highs, start, end))


def is_straight(lows: list[float], highs: list[float], start: int, end: int) -> bool:
    """Whether a straight line passes between the limits: a linear programme in two unknowns."""
    x = np.linspace(-1, 1, end - start + 1)
    low, high = np.array(lows[start : end + 1]), np.array(highs[start : end + 1])
    line = np.column_stack([np.ones_like(x), x])
    found = linprog(
        np.zeros(2), np.vstack([line, -line]), np.concatenate([high, -low]), bounds=(None, None)
    )
    return bool(found.status == 0)


@every_circuit
def test_both_sides_compute_the_same_circuit(name: str) -> None:
    part = sensor(name)
    chain = circuit(part, UNO.mcu)
    celsius = np.linspace(*part.range_c, 101)
    ratios = [chain.ratio(float(each)) for each in celsius]
    np.testing.assert_allclose(ratios, shares(part, UNO, celsius), rtol=1e-10)
    back = [chain.celsius(ratio) for ratio in ratios]
    np.testing.assert_allclose(back, celsius, atol=1e-8)


@every_circuit
def test_open_and_short_are_on_the_sides_that_the_limits_say(name: str) -> None:
    part = sensor(name)
    bounds = limits(part, UNO.mcu)
    full_v = reference_v(part, UNO)
    opened, shorted = (
        min(int(CODES * float(pin_v(part, 25.0, wiring)) / full_v), CODES - 1)
        for wiring in (Wiring(opened=True), Wiring(shorted=True))
    )
    assert bounds.open_is_high == (opened > shorted)
    assert (bounds.low_limit, bounds.high_limit) == (min(opened, shorted), max(opened, shorted))
    assert bounds.low_limit < bounds.far_low <= bounds.low
    assert bounds.high <= bounds.far_high < bounds.high_limit


@every_circuit
def test_the_ends_of_the_range_are_valid(name: str) -> None:
    part = sensor(name)
    bounds = limits(part, UNO.mcu)
    inside = np.floor(CODES * shares(part, UNO, np.linspace(*part.range_c, 10_001)))
    assert (inside.min(), inside.max()) == (bounds.low, bounds.high)


@every_circuit
def test_its_largest_step(name: str) -> None:
    part = sensor(name)
    celsius = np.linspace(*part.range_c, 200_001)
    steepest = np.abs(np.diff(shares(part, UNO, celsius))).min() / (celsius[1] - celsius[0])
    # A step at the range's end reaches a little beyond it, where the curve is flatter still.
    assert conversion(part, UNO.mcu).step_k == pytest.approx(1 / CODES / steepest, rel=0.1)


def test_a_straight_line_needs_two_points() -> None:
    for name in ("lm35", "tmp36", "falling"):
        assert len(conversion(sensor(name), UNO.mcu).points) == 2


def test_a_range_that_the_circuit_does_not_show_has_no_table() -> None:
    """The feeder's amplifier gives nothing below 0 °C, and no more than 3.3 V."""
    for ends in ((0.0, 250.0), (2.0, 270.0)):
        part = sensor("feeder").model_copy(update={"range_c": ends})
        assert not limits(part, UNO.mcu).shown
        with pytest.raises(ValueError, match="within what its circuit can show"):
            conversion(part, UNO.mcu)
