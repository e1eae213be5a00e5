"""Off, by hand, bands, gains that change: what a host may make of a loop."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_commanded import Commanded, controller_of

from heatwright.sim.reference.inputs import AUTOMATIC, Gains
from heatwright.sim.reference.numbers import Single

SINGLE = 2**-22
"""A few roundings of numbers up to some hundreds, relatively."""


@pytest.fixture
def loop():
    return Commanded(controller_of())


def test_a_setpoint_of_zero_is_off(loop):
    loop.feed(45.0)
    loop.setpoint_c = 0.0
    record = loop.feed(45.0)
    assert record["duty_percent"] == 0
    assert [record[f"algorithm.{name}"] for name in ("integral", "proportional", "started")] == [
        0
    ] * 3


def test_off_is_only_for_commanded_loops(vary, chamber):
    assert "mode" not in dict(Commanded(chamber, 0.0).reference.members)


def test_off_does_not_run_away_and_still_must_not_heat():
    loop = Commanded(
        controller_of(protection="runaway: {above: 5 K, below: 5 K, for: 3 s}, rise_rate: 100 K/s")
    )
    loop.feed_all([50.0, 50.0])
    loop.setpoint_c = 0.0
    assert {r["fault.code"] for r in loop.feed_all([60.0] * 9)} == {0}
    assert {r["fault.code"] for r in loop.feed_all([60.0] * 120)} == {0}
    assert loop.feed(70.0)["fault.code"] == 13


def test_by_hand_no_band_is_watched():
    rules = "frozen: off, runaway: {above: 5 K, below: 5 K, for: 3 s}, rise_rate: 100 K/s"
    loop = Commanded(controller_of(protection=rules))
    loop.feed_all([50.0, 50.0])
    loop.by_hand(20.0)
    assert {r["fault.code"] for r in loop.feed_all([20.0] * 9)} == {0}


@pytest.mark.parametrize("reading_c", [20.0, 60.0])
def test_by_hand_a_still_reading_is_watched_wherever_the_setpoint_is(reading_c):
    loop = Commanded(controller_of(protection="frozen: {for: 5 s}"))
    loop.by_hand(20.0)
    loop.feed(reading_c)
    assert [r["fault.code"] for r in loop.feed_all([reading_c] * 5)] == [0, 0, 0, 0, 9]


def test_by_hand_a_still_reading_without_heat_is_none():
    loop = Commanded(controller_of(protection="frozen: {for: 5 s}"))
    loop.by_hand(0.0)
    assert {r["fault.code"] for r in loop.feed_all([20.0] * 9)} == {0}


def test_by_hand_full_power_must_still_show():
    rules = "heating: {rise: 2 K, within: 4 s}, frozen: off"
    loop = Commanded(controller_of(protection=rules))
    loop.by_hand(100.0)
    assert [r["fault.code"] for r in loop.feed_all([20.0] * 5)] == [0, 0, 0, 0, 10]


def test_by_hand_the_duty_is_limited_as_any():
    loop = Commanded(controller_of("output: {minimum: 10 %, maximum: 60 %}", "ready_within: 1 K"))
    loop.by_hand(90.0)
    assert loop.feed(45.0)["duty_percent"] == 60
    loop.by_hand(1.0)
    assert loop.feed(45.0)["duty_percent"] == 10


@given(st.integers(-64, 64), st.integers(-4, 4), st.floats(0, 100, width=32))
def test_the_return_from_manual_does_not_jump(sixteenths, slope, percent):
    """As long as the integral's limits let it follow."""
    loop = Commanded(controller_of())
    loop.by_hand(percent)
    base_c = 50 + sixteenths / 16
    records = loop.feed_all([base_c - slope / 16, base_c])
    assert records[-1]["duty_percent"] == Single(percent)
    loop.mode = AUTOMATIC
    before = records[-1]
    inside = 0 < before["algorithm.integral"] < 100
    after = loop.feed(base_c)  # the slope has ended: take its part out of the comparison
    drop = 8 * (float(before["algorithm.derivative"]) - float(after["algorithm.derivative"]))
    expected = percent - drop + 0.5 * -sixteenths / 16
    if inside and 0 < expected < 100:
        assert after["duty_percent"] == pytest.approx(expected, abs=100 * SINGLE)


@given(
    st.lists(st.integers(-32, 32), min_size=2, max_size=5),
    st.floats(0.5, 20, width=32),
    st.floats(0.5, 20, width=32),
)
def test_new_gains_do_not_jump(sixteenths, kp, kd):
    temperatures_c = [50 + n / 16 for n in sixteenths]
    loop = Commanded(controller_of())
    loop.feed_all(temperatures_c)
    twin = Commanded(controller_of())
    twin.feed_all(temperatures_c)
    twin.gains = Gains(Single(kp), Single(0.5), Single(kd))
    old, new = loop.feed(50.0), twin.feed(50.0)
    inside = 0 < new["algorithm.integral"] < 100 and 0 < old["algorithm.integral"] < 100
    if inside and 0 < old["duty_percent"] < 100:
        assert new["duty_percent"] == pytest.approx(old["duty_percent"], abs=300 * SINGLE)
        assert new["algorithm.kp"] == Single(kp)


def test_gains_are_taken_over_when_pid_does_a_step(loop):
    loop.feed(45.0)
    loop.gains = Gains(Single(3), Single(1), Single(0))
    assert loop.miss()["algorithm.kp"] == 2
    loop.setpoint_c = 0.0
    assert loop.feed(45.0)["algorithm.kp"] == 2
    loop.setpoint_c = 50.0
    assert [loop.feed(45.0)[f"algorithm.{gain}"] for gain in Gains._fields] == [3, 1, 0]


def test_without_integral_gain_the_integral_stays(loop):
    loop.feed_all([49.0] * 4)
    loop.gains = Gains(Single(2), Single(0), Single(8))
    records = loop.feed_all([49.0] * 3)
    assert [record["algorithm.integral"] for record in records] == [2, 2, 2]


def test_a_tunable_loop_needs_its_gains(loop):
    loop.gains = None
    with pytest.raises(ValueError, match="gains"):
        loop.feed(45.0)


def test_outside_the_band_all_or_nothing():
    loop = Commanded(
        controller_of(
            "band: 4 K, integral: {minimum: 20 %, maximum: 60 %}, output: {maximum: 90 %}",
            "ready_within: 1 K",
        )
    )
    records = loop.feed_all([45.9375, 46.0, 49.0, 54.0, 54.0625])
    assert [bool(r["duty_percent"] == 90) for r in records] == [True, False, False, False, False]
    assert records[0]["algorithm.integral"] == 20
    assert records[2]["algorithm.integral"] > 20
    assert (records[4]["duty_percent"], records[4]["algorithm.integral"]) == (0, 20)
    assert records[4]["algorithm.derivative"] != 0


def test_above_the_band_not_even_the_least_duty():
    loop = Commanded(controller_of("band: 4 K, output: {minimum: 10 %}"))
    assert [r["duty_percent"] for r in loop.feed_all([54.0, 55.0])] == [10, 0]


def test_in_the_dead_band_only_the_derivative_speaks():
    loop = Commanded(controller_of("dead_band: 0.125 K"))
    loop.feed_all([48.0, 48.0, 49.0])
    held = loop.feed(49.875)
    assert (held["algorithm.proportional"], held["algorithm.derivative"]) == (0, -0.875)
    still = loop.feed(49.875)
    assert still["algorithm.integral"] == held["algorithm.integral"]
    assert still["duty_percent"] == still["algorithm.integral"]
    out = loop.feed(49.8125)
    assert out["algorithm.proportional"] == 2 * 0.1875
    assert out["algorithm.integral"] > still["algorithm.integral"]


def test_a_stop_is_a_fault_until_it_is_acknowledged(loop):
    loop.feed(45.0)
    loop.reference.stop()
    record = loop.feed(45.0)
    assert (record["fault.code"], record["fault.temperature_c"], record["duty_percent"]) == (
        19,
        0,
        0,
    )
    loop.reference.acknowledge()
    assert loop.feed(45.0)["fault.code"] == 0


def test_a_stop_hides_no_other_fault(loop):
    loop.feed_all([45.0, 119.0])
    loop.reference.stop()
    assert loop.feed(119.0)["fault.code"] == 8
