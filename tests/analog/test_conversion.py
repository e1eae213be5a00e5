"""Curves and tables of analog sensors. The firmware's tables are as exact as they say, and no line
with fewer points is. Of the curves of sensing elements the standard's own numbers, and two ways to
compute each, agree. The curve that a simulated sensor's voltage is taken from is its circuit, to a
hair of a code."""

import random
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig.firmware import ROOT
from rig.sensors import CIRCUITS, sensor
from scipy.optimize import linprog

from heatwright.sim.circuits import Wiring, pin_v, reference_v, shares
from heatwright.sim.reference.sensors.adc import converter
from heatwright.sim.sensors.adc_sensor import ABOVE_K, BELOW_K, PER_K, curve_of
from heatwright.spec import BOARDS, CodesCurve, Thermistor
from heatwright.spec.sensing.conversion import CODES, conversion, limits
from heatwright.spec.sensing.curves import LinearPlatinum, Platinum
from heatwright.spec.sensing.fewest import Tube, fewest_points

UNO = BOARDS["uno"]
DOCS = ROOT / "docs"

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


@pytest.mark.parametrize("name", [name for name in CIRCUITS if "codes" in name])
def test_a_table_of_codes_reads_as_in_the_firmware_that_had_it(name: str) -> None:
    """That one interpolates between its pairs; half a step of the ADC is what ours leaves it."""
    part = sensor(name)
    assert isinstance(part, Thermistor)
    assert isinstance(part.curve, CodesCurve)
    table = sorted(part.curve.codes)
    codes, at_c = np.array(table).T
    bounds, law = limits(part, UNO.mcu), converter(part, UNO)
    raw = np.arange(part.oversample * bounds.low, part.oversample * bounds.high + 1)
    sums = raw / part.oversample * part.curve.readings
    sides = (sums + side * part.curve.readings for side in (0, 0.5, -0.5))
    theirs, up, down = (np.interp(each, codes, at_c) for each in sides)
    ours = np.array([law(int(each)) for each in raw], float)
    inside = (sums - part.curve.readings > codes[0]) & (sums + part.curve.readings < codes[-1])
    room = np.abs(np.where(np.sign(ours - theirs) == np.sign(up - down), up, down) - theirs)
    assert (np.abs(ours - theirs) <= room + 1e-4)[inside].all()
    assert len(conversion(part, UNO.mcu).points) <= len(table) + 1


@given(st.floats(-60, 700))
def test_codes_both_ways(celsius: float) -> None:
    """Within the table and beyond it; at its pairs it is what they say."""
    part = sensor("steep_codes")
    assert isinstance(part, Thermistor)
    assert isinstance(part.curve, CodesCurve)
    chain = part.circuit(UNO.mcu)
    ratio = chain.ratio(celsius)
    assert ratio == pytest.approx(float(shares(part, UNO, celsius)), rel=1e-10)
    assert chain.celsius(ratio) == pytest.approx(celsius, abs=1e-6)
    for code, at_c in part.curve.codes:
        assert chain.ratio(at_c) == pytest.approx((code / 16 + 0.5) / 1024, rel=AGREE)


@every_circuit
def test_both_sides_compute_the_same_circuit(name: str) -> None:
    part = sensor(name)
    chain = part.circuit(UNO.mcu)
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


def test_a_range_that_the_circuit_does_not_show_has_no_table() -> None:
    """The feeder's amplifier gives nothing below 0 °C, and no more than 3.3 V."""
    for ends in ((0.0, 250.0), (2.0, 270.0)):
        part = sensor("feeder").model_copy(update={"range_c": ends})
        assert not limits(part, UNO.mcu).shown
        with pytest.raises(ValueError, match="within what its circuit can show"):
            conversion(part, UNO.mcu)


def feasible(tube: Tube, bends: tuple[int, ...]) -> bool:
    """Whether some line with these bends stays in the tube: a linear programme in their values."""
    places = range(len(tube.lows))
    weights = np.column_stack([np.interp(places, bends, unit) for unit in np.eye(len(bends))])
    bounds = np.concatenate([tube.highs, -np.array(tube.lows)])
    both = np.vstack([weights, -weights])
    return bool(linprog(np.zeros(len(bends)), both, bounds, bounds=(None, None)).status == 0)


def by_trying(tube: Tube) -> int:
    """Fewest points, by trying all sets of bends, smallest sets first."""
    last = len(tube.lows) - 1
    for inner in range(last):
        for bends in combinations(range(1, last), inner):
            if feasible(tube, (0, *bends, last)):
                return inner + 2
    raise AssertionError("not even a bend at every place will do")


def random_tube(seed: int) -> Tube:
    picked = random.Random(seed)  # noqa: S311 - no secret
    size = picked.randint(2, 9)
    shape = picked.choice(("walk", "sine", "decay"))
    values, value = [], 0.0
    for place in range(size):
        value += picked.gauss(0, 1)
        smooth = np.sin(place * 0.9) * 4 if shape == "sine" else 9 * np.exp(-place / 3)
        values.append(value if shape == "walk" else smooth)
    widths = [picked.uniform(0.02, 1.0) for _ in values]
    return Tube(
        [value - width for value, width in zip(values, widths, strict=True)],
        [value + picked.uniform(0.02, 1.0) for value in values],
    )


@pytest.mark.parametrize("seed", range(60))
def test_no_set_of_fewer_bends_will_do(seed: int) -> None:
    tube = random_tube(seed)
    points = fewest_points(tube)
    assert len(points) == by_trying(tube)


@pytest.mark.parametrize("seed", range(200))
def test_the_line_stays_in_the_tube(seed: int) -> None:
    tube = random_tube(seed)
    places, values = zip(*fewest_points(tube), strict=True)
    assert (places[0], places[-1]) == (0, len(tube.lows) - 1)
    assert all(left < right for left, right in pairwise(places))
    line = np.interp(range(len(tube.lows)), places, values)
    scale = max(abs(value) for value in (*tube.lows, *tube.highs))
    assert np.all(line >= np.array(tube.lows) - 8 * np.finfo(float).eps * scale)
    assert np.all(line <= np.array(tube.highs) + 8 * np.finfo(float).eps * scale)


def test_a_tube_of_one_place_has_one_point_and_a_closed_one_is_refused() -> None:
    assert fewest_points(Tube([1.0], [2.0])) == [(0, 1.5)]
    with pytest.raises(ValueError, match="crossed"):
        fewest_points(Tube([0.0, 2.0], [1.0, 1.0]))


IEC_60751 = {
    -200: 18.52, -100: 60.26, -50: 80.31, 0: 100.0, 25: 109.73, 100: 138.51, 200: 175.86,
    250: 194.10, 400: 247.09, 600: 313.71, 850: 390.48,
}  # fmt: skip
"""Resistance of a Pt100 by temperature, the standard's table: rounded to 0.01 Ω."""

AGREE = 1e-12  # relative; both ways are in double precision, with few operations of 1.1e-16 each


@pytest.mark.parametrize("celsius", IEC_60751)
def test_platinum_is_that_of_the_standard(celsius: int) -> None:
    assert Platinum(100.0).ohm(celsius) == pytest.approx(IEC_60751[celsius], abs=0.005)
    assert Platinum(1000.0).ohm(celsius) == pytest.approx(10 * IEC_60751[celsius], abs=0.05)


@given(st.floats(-200, 850))
def test_platinum_and_back(celsius: float) -> None:
    curve = Platinum(100.0)
    assert curve.celsius(curve.ohm(celsius)) == pytest.approx(celsius, abs=1e-9)


@pytest.mark.parametrize("code", range(341, 700))
def test_a_line_in_a_divider_of_twice_its_zero_is_its_authors_formula(code: int) -> None:
    """T = (3·adc − 1024) · 10⁶ / 3925 / (1024 − adc), as the fabricator's author has it."""
    chain = sensor("linear").circuit(UNO.mcu)
    author_c = (3 * code - 1024) * 1e6 / 3925 / (1024 - code)
    assert chain.celsius(code / 1024) == pytest.approx(author_c, abs=1e-9)
    assert 1024 * shares(sensor("linear"), UNO, author_c) == pytest.approx(code, abs=1e-9)


ON_THE_LINE = {50: 49.4, 100: 98.1, 200: 193.3, 250: 239.7, 300: 285.5, 400: 374.8}
"""What 3925 ppm/K make of an element of IEC 60751, °C: the table in docs/language.md."""


def test_how_far_a_line_is_off_the_standard() -> None:
    line, curve = LinearPlatinum(1000.0, 3925e-6), Platinum(1000.0)
    shown = {at_c: round(line.celsius(curve.ohm(at_c)), 1) for at_c in ON_THE_LINE}
    assert shown == ON_THE_LINE
    assert round(curve.celsius(line.ohm(300.0)), 1) == 316.0
    row = " | ".join(str(each) for each in ON_THE_LINE.values())
    assert f"| shown, °C | {row} |" in (DOCS / "language.md").read_text("utf-8")


CODE_MV = 1000 * 5 / 1024
SPOILT = {
    "sound": Wiring(), "corroded": Wiring(series_ohm=100.0), "leaking": Wiring(parallel_ohm=10e3),
    "opened": Wiring(opened=True), "shorted": Wiring(shorted=True),
}  # fmt: skip


@pytest.mark.parametrize("wiring", SPOILT)
@pytest.mark.parametrize("name", CIRCUITS)
def test_it_lacks_a_hundredth_of_a_code_at_most(name: str, wiring: str) -> None:
    """Straight between two points it lacks V''/8 · h²: h is a 64th of a kelvin."""
    part, spoilt = sensor(name), SPOILT[wiring]
    curve = curve_of(part, spoilt)
    low_c, high_c = part.range_c
    at_c = curve.first + np.arange(len(curve.millivolts)) / PER_K
    assert at_c[0] <= low_c - BELOW_K + 1
    assert at_c[-1] >= high_c + ABOVE_K - 1
    between_c = np.random.default_rng(1).uniform(at_c[0], at_c[-1], 100_000)
    lacks_mv = np.interp(between_c, at_c, curve.millivolts) - 1000 * pin_v(part, between_c, spoilt)
    assert np.abs(lacks_mv).max() <= CODE_MV / 100, between_c[np.abs(lacks_mv).argmax()]
