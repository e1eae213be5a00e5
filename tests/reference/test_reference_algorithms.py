"""Sequences computed by hand, with numbers that single precision holds exactly."""

import numpy as np
import pytest
from player import Player

from heatwright.sim.reference.numbers import Single, filter_share, steps
from heatwright.spec import OnOff, Pid

FREE = {"heating": None, "runaway": None, "frozen": None, "rising_while_off": None}


def on_off(vary, **limits):
    return Player(vary(**FREE, algorithm=OnOff(kind="on_off", **limits)))


def pid(vary, **settings):
    return Player(vary(**FREE, algorithm=Pid.model_validate({"kind": "pid", **settings})))


def duties(records):
    return [float(record["duty_percent"]) for record in records]


def test_threshold_is_off_at_the_setpoint(vary):
    player = on_off(vary)
    assert duties(player.feed_all([49.9375, 50.0, 50.0625, 49.9375])) == [100, 0, 0, 100]


def test_hysteresis_switches_at_both_ends_of_its_band(vary):
    player = on_off(vary, hysteresis="1 K")
    temperatures_c = [49.0625, 49.0, 49.5, 50.9375, 51.0, 50.0, 49.0625, 49.0]
    assert duties(player.feed_all(temperatures_c)) == [0, 100, 100, 100, 0, 0, 0, 100]


def test_lead_adds_the_filtered_slope(vary):
    player = on_off(vary, lead="4 s", lead_filter="1 s")
    records = player.feed_all([48.0, 49.0, 49.0, 49.0])
    assert [float(r["algorithm.rate_k_per_s"]) for r in records] == [0, 0.5, 0.25, 0.125]
    assert duties(records) == [100, 0, 0, 100]  # expected 48, 51, 50, 49.5 °C


def test_the_slope_is_kept_over_missing_readings(vary):
    player = on_off(vary, lead="4 s", lead_filter="1 s")
    player.feed_all([40.0, 41.0])
    kept = player.miss()
    assert kept["algorithm.heating"] == 1
    assert kept["duty_percent"] == 0
    assert player.feed(43.0)["algorithm.rate_k_per_s"] == 0.5
    assert player.feed(44.0)["algorithm.rate_k_per_s"] == 0.75


def test_a_fault_resets_on_off(vary):
    player = on_off(vary, lead="4 s", lead_filter="1 s")
    player.feed_all([40.0, 41.0])
    record = player.feed(51.0)
    assert record["fault.code"] == 8
    assert (record["algorithm.rate_k_per_s"], record["algorithm.heating"]) == (0, 0)


def test_proportional_and_its_limits(vary):
    player = pid(vary, kp=50)
    assert duties(player.feed_all([46.0, 48.0, 49.0, 50.0, 51.0])) == [100, 100, 50, 0, 0]


def test_integral_sums_the_error_and_stops_at_its_limits(vary):
    player = pid(vary, kp=0.5, ki=2, integral={"maximum": "6 %", "while_limited": "run"})
    records = player.feed_all([49.0, 49.0, 48.5, 49.0, 52.0, 52.0, 52.0])
    assert [float(r["algorithm.integral"]) for r in records] == [2, 4, 6, 6, 2, 0, 0]
    assert duties(records) == [2.5, 4.5, 6.75, 6.5, 1, 0, 0]


def test_integral_starts_at_its_least(vary):
    player = pid(vary, kp=1, ki=1, integral={"minimum": "20 %", "maximum": "60 %"})
    assert player.feed(49.0)["algorithm.integral"] == 21


@pytest.mark.parametrize(("mode", "expected"), [("hold", [0, 0, 1]), ("run", [4, 8, 9])])
def test_integral_at_the_limit_of_the_output(vary, mode, expected):
    player = pid(vary, kp=50, ki=1, integral={"while_limited": mode})
    records = player.feed_all([46.0, 46.0, 49.0])
    assert [float(r["algorithm.integral"]) for r in records] == expected


def test_a_held_integral_leaves_through_the_other_side(vary):
    player = pid(vary, kp=1, ki=1, output={"maximum": "10 %"})
    records = player.feed_all([46.0, 46.0, 46.0, 51.0])
    assert [float(r["algorithm.integral"]) for r in records] == [4, 4, 4, 3]
    assert duties(records) == [8, 10, 10, 2]


def test_held_below_zero(vary):
    player = pid(vary, kp=4, ki=1)
    records = player.feed_all([48.0, 52.0, 52.0])
    assert [float(r["algorithm.integral"]) for r in records] == [2, 2, 2]
    assert duties(records) == [10, 0, 0]


def test_derivative_of_the_measurement_does_not_see_the_setpoint(vary):
    player = pid(vary, kp=1, kd=8, derivative_filter="1 s")
    player.feed(49.0)
    player.setpoint_c = 60.0
    record = player.feed(49.5)
    assert record["algorithm.derivative"] == -0.25
    assert record["algorithm.last"] == 49.5
    assert record["duty_percent"] == 10.5 - 2


def test_derivative_of_the_error_sees_the_setpoint(vary):
    player = pid(vary, kp=1, kd=8, derivative_of="error", derivative_filter="1 s")
    player.feed(49.0)
    player.setpoint_c = 60.0
    record = player.feed(49.5)
    assert record["algorithm.derivative"] == (10.5 - 1.0) / 2
    assert record["algorithm.last"] == 10.5
    assert record["duty_percent"] == 10.5 + 8 * 4.75


@pytest.mark.parametrize("kind", ["error", "measurement"])
def test_the_derivative_is_kept_over_missing_readings(vary, kind):
    player = pid(vary, kp=1, kd=8, derivative_of=kind, derivative_filter="1 s")
    player.feed_all([40.0, 41.0])
    player.miss()
    assert player.feed(43.0)["algorithm.derivative"] == -0.5
    assert player.feed(44.0)["algorithm.derivative"] == -0.75


def test_a_fault_resets_pid_but_for_the_last_value(vary):
    player = pid(vary, kp=1, ki=1, kd=8)
    player.feed_all([48.0, 48.5])
    record = player.feed(55.0)
    assert record["fault.code"] == 8
    names = ("proportional", "integral", "derivative", "started", "last")
    assert [float(record[f"algorithm.{name}"]) for name in names] == [0, 0, 0, 0, 48.5]
    assert player.feed(48.0, acknowledge=True)["fault.code"] == 8  # a jump again
    record = player.feed(48.0, acknowledge=True)
    assert record["algorithm.derivative"] == 0


@pytest.mark.parametrize(
    ("gains", "members"),
    [
        ({"kp": 1}, ["proportional"]),
        ({"kp": 1, "ki": 1}, ["proportional", "integral", "started"]),
        ({"kp": 1, "kd": 1}, ["proportional", "derivative", "last", "started"]),
        (
            {"kp": 1, "ki": 1, "kd": 1},
            ["proportional", "integral", "derivative", "last", "started"],
        ),
    ],
)
def test_terms_without_a_gain_leave_no_members(vary, gains, members):
    record = pid(vary, **gains).feed(40.0)
    assert [name[10:] for name in record if name.startswith("algorithm.")] == members


def test_every_operation_is_rounded_to_single_precision(vary):
    player = pid(vary, kp=0.1, ki=0.3, kd=0.7, derivative_filter="3 s")
    player.feed(40.0)
    record = player.feed(40.0625)
    kp, ki, kd = np.float32([0.1, 0.3, 0.7])
    integral = np.float32(0.0) + ki * np.float32(10.0)
    integral = integral + ki * np.float32(9.9375)
    derivative = np.float32(0.25) * np.float32(-0.0625)
    expected = kp * np.float32(9.9375) + integral + kd * derivative
    assert record["duty_percent"].tobytes() == expected.tobytes()
    assert isinstance(record["duty_percent"], np.float32)
    assert float(record["duty_percent"]) != 0.1 * 9.9375 + 0.3 * 19.9375 - 0.7 * 0.015625


def test_a_duration_is_counted_in_whole_milliseconds():
    assert 0.3 / 0.1 < 3
    assert steps(0.3, 0.1) == 3
    assert steps(0.29, 0.1) == 2
    assert steps(0.01, 1.0) == 1
    assert steps(120.0, 1.0) == 120


def test_filter_of_four_periods_takes_a_fifth():
    assert filter_share(1.0, 4.0) == Single(0.2)
    assert filter_share(1.0, 0.0) == 1
