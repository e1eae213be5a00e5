"""The law of programs, on courses whose every step is known."""

import numpy as np
import pytest
from programmed_kiln import Kiln, begun, controller_of

from heatwright.sim.reference.program_state import (
    FAILED,
    FINISHED,
    FOR_OPERATOR,
    FOR_TARGET,
    HELD_BACK,
    IDLE,
    NOTHING,
    PAUSED,
    RETURNING,
    RUNNING,
    STOPPED,
)

OVER, RATE, FAST, HOLD, UNTIL = range(1, 6)
LAGS = 24


def setpoints(records):
    return [float(record["setpoint_c"]) for record in records]


def test_a_start_begins_at_the_temperature_and_switches_the_loop_on(kiln):
    assert kiln.feed(25.0)["enabled"] == 0
    record = kiln.start(temperature_c=27.5)
    assert (record["enabled"], record["setpoint_c"], record["program.first_c"]) == (1, 27.5, 27.5)
    assert kiln.of_program("state", "number", "segment", "segments", "order", "argument", "leap") \
        == (RUNNING, 1, 1, 3, 3, 1, 1)  # fmt: skip
    assert kiln.of_program("kind", "to_dc", "amount", "length", "elapsed", "clock") \
        == (OVER, 400, 20, 20, 0, 0)  # fmt: skip


def test_the_setpoint_moves_every_period_in_a_straight_line():
    kiln = begun()
    assert setpoints(kiln.follow(20)) == [20.0 + step for step in range(1, 21)]
    assert kiln.of_program("segment", "elapsed") == (2, 0)  # reached: the hold has begun


def test_a_target_has_to_be_reached_before_the_next_segment_begins():
    kiln = begun()
    kiln.follow(20, above_k=-3.0)
    assert kiln.of_program("segment", "waiting", "elapsed") == (1, FOR_TARGET, 20)
    kiln.feed(38.9921875)
    assert kiln.of_program("segment", "waiting") == (1, FOR_TARGET)
    kiln.feed(39.0)  # within 1 K
    assert kiln.of_program("segment", "waiting", "kind") == (2, NOTHING, HOLD)


def test_a_way_down_is_reached_from_above():
    kiln = Kiln(controller_of("{to: 30 °C, over: 2 s}, {hold: 1 min}"))
    kiln.start(temperature_c=34.0)
    kiln.feed_all([34.0, 33.0, 31.0078125])
    assert kiln.of_program("segment", "waiting") == (1, FOR_TARGET)
    kiln.feed(31.0)
    assert kiln.of_program("segment") == (2,)


def test_a_hold_lasts_its_steps_and_the_last_segment_ends_the_program():
    kiln = begun(20)
    kiln.follow(4)
    assert kiln.of_program("segment", "elapsed") == (2, 4)
    kiln.follow(1)
    assert kiln.of_program("segment", "from_c", "to_c") == (3, 40.0, 30.0)
    kiln.follow(6)  # a step late, as it reads what the setpoint was
    assert kiln.of_program("state", "ended") == (IDLE, FINISHED)
    assert (kiln.record["enabled"], kiln.record["duty_percent"]) == (0, 0)
    assert kiln.of_program("clock", "segment_clock") == (31, 6)


def test_at_the_end_the_loop_may_hold():
    kiln = begun(31, controller_of(programs="at_end: hold"))
    for _ in range(3):
        assert kiln.of_program("state", "ended") == (IDLE, FINISHED)
        assert (kiln.record["enabled"], kiln.record["setpoint_c"]) == (1, 30.0)
        kiln.feed(29.0)


def test_a_last_ramp_that_is_skipped_leads_no_further():
    kiln = begun(0, controller_of("{to: 30 °C, over: 10 s}", programs="at_end: hold"))
    came_to_c = kiln.follow(4)[-1]["setpoint_c"]
    assert came_to_c == 24.0
    assert kiln.order("skip")
    kiln.follow(1)
    assert kiln.of_program("state", "ended") == (IDLE, FINISHED)
    assert (kiln.record["enabled"], kiln.record["setpoint_c"]) == (1, came_to_c)


def test_what_is_no_setpoint_of_the_loop_is_not_held():
    kiln = Kiln(controller_of("{hold: 2 s}", programs="at_end: hold"))
    kiln.start(temperature_c=-5.0)
    kiln.feed_all([-5.0, -5.0])
    assert (*kiln.of_program("state", "ended"), kiln.record["enabled"]) == (IDLE, FINISHED, 0)


def test_a_rate_takes_as_long_as_it_takes():
    """21 K at 7200 K/h are 10.5 s: a step more than 10 is the nearest of the two."""
    kiln = begun(0, controller_of("{to: 41 °C, at: 6000 K/h}"))
    assert kiln.of_program("kind", "amount", "length") == (RATE, 60000, 13)
    assert kiln.follow(13)[-1]["setpoint_c"] == 41.0


def test_a_rate_over_no_way_takes_a_step():
    kiln = begun(0, controller_of("{to: 20 °C, at: 1 K/h}, {hold: 1 min}"))
    assert kiln.of_program("length") == (1,)
    kiln.feed(20.0)
    assert kiln.of_program("segment") == (2,)


def test_the_slowest_rate_is_not_longer_than_a_float_can_count():
    kiln = begun(0, controller_of("{to: 1000 °C, at: 0.1 K/h}"))
    assert kiln.of_program("length") == (16_777_215,)


def test_as_fast_as_possible_leaps_and_waits():
    kiln = begun(0, controller_of("{to: 100 °C, at: as fast as possible}, {hold: 1 min}"))
    assert kiln.of_program("kind", "length", "setpoint_c", "leap") == (FAST, 0, 100.0, 1)
    for _ in range(100):  # no limit: heating_failed watches full power
        kiln.feed(20.0)
    assert kiln.of_program("waiting", "waited") == (FOR_TARGET, 0)
    kiln.feed(99.0)
    assert kiln.of_program("segment") == (2,)


def test_until_waits_for_the_operator(kiln):
    kiln.start(2)
    kiln.follow(50)
    assert kiln.of_program("state", "kind", "waiting") == (RUNNING, UNTIL, FOR_OPERATOR)
    assert kiln.order("skip")
    kiln.follow(1)
    assert kiln.of_program("state", "ended") == (IDLE, FINISHED)


@pytest.mark.parametrize(("away_k", "waiting"), [(10.0, 0), (10.0078125, 1), (-10.5, 1)])
def test_the_clock_waits_while_the_kiln_is_away(away_k, waiting):
    kiln = begun(5)
    kiln.feed(25.0 - away_k)
    moved = waiting == NOTHING
    assert kiln.of_program("waiting", "elapsed") == (waiting, 5 + moved)
    assert float(kiln.record["program.rate_k_per_s"]) == float(moved)
    assert kiln.of_program("clock", "segment_clock") == (6, 6)  # these go on


def test_a_kiln_that_lags_for_too_long_is_a_fault():
    kiln = begun(20)
    kiln.follow(5)
    kiln.feed_all([25.0] * 4)
    assert kiln.of_program("waited", "waiting") == (4, HELD_BACK)
    record = kiln.feed(25.0)
    assert (record["fault.code"], record["fault.temperature_c"]) == (LAGS, 25.0)
    assert record["duty_percent"] == 0
    assert kiln.of_program("state") == (RUNNING,)
    kiln.feed(25.0)
    assert (*kiln.of_program("state", "ended"), kiln.record["enabled"]) == (IDLE, FAILED, 0)


def test_one_that_is_near_now_and_then_lags_all_the_same():
    kiln = begun(20)
    kiln.feed_all([25.0, 40.0, 25.0, 40.0, 25.0, 25.0])
    assert (kiln.record["fault.code"], *kiln.of_program("waited")) == (0, 4)
    assert kiln.feed(25.0)["fault.code"] == LAGS


def test_each_segment_is_counted_by_itself():
    kiln = begun(0, controller_of("{to: 40 °C, over: 1 s}, {to: 60 °C, over: 1 s}"))
    kiln.feed_all([20.0] * 4)
    assert kiln.of_program("segment", "waited") == (1, 4)
    kiln.feed(40.0)
    assert kiln.of_program("segment", "waited") == (2, 0)
    kiln.feed(40.0)
    assert kiln.of_program("segment", "waited") == (2, 1)


def test_one_that_cools_slowly_is_waited_for():
    kiln = Kiln(controller_of("{to: 30 °C, over: 5 s}", runaway="off"))
    kiln.start(temperature_c=100.0)
    for _ in range(200):
        kiln.feed(99.0)
    assert (kiln.record["fault.code"], *kiln.of_program("waiting", "waited")) == (0, HELD_BACK, 0)


def test_without_a_hold_back_nothing_is_waited_for():
    kiln = begun(0, controller_of(programs="hold_back: off", runaway="off"))
    kiln.feed_all([20.0] * 20)
    assert kiln.of_program("waiting", "elapsed") == (FOR_TARGET, 20)
    kiln.feed_all([20.0] * 20)
    assert (kiln.record["fault.code"], *kiln.of_program("waited")) == (0, 21)


def test_without_a_reading_only_the_clocks_go_on():
    kiln = begun(5)
    kiln.miss()
    assert kiln.of_program("clock", "segment_clock", "elapsed") == (6, 6, 5)
    assert (kiln.record["setpoint_c"], kiln.record["duty_percent"]) == (25.0, 0)


def test_the_energy_is_the_sum_of_the_duty():
    kiln = begun()
    records = kiln.follow(20, above_k=-8.0)
    permille = [
        int(np.float32(r["duty_percent"]) * np.float32(10) + np.float32(0.5)) for r in records
    ]
    assert sum(permille) > 1000
    assert kiln.of_program("energy") == (sum(permille),)


def test_the_feed_forward_brings_what_the_slope_needs():
    controller = controller_of(algorithm="feed_forward: 30")
    kiln = Kiln(controller)
    kiln.start()
    record = kiln.feed(20.0)
    assert (record["algorithm.proportional"], record["duty_percent"]) == (1.0, 31.0)
    assert kiln.order("pause")
    kiln.feed(20.0)
    assert (kiln.record["duty_percent"], *kiln.of_program("rate_k_per_s")) == (0, 0)


def test_other_periods_have_other_steps():
    """The setpoint of a ramp is a share of its way, whatever the period."""
    kiln = begun(0, controller_of("{to: 40 °C, over: 20 s}", period="0.5 s"))
    assert kiln.of_program("length") == (40,)
    assert setpoints(kiln.follow(3)) == [20.5, 21.0, 21.5]
    assert float(kiln.record["program.rate_k_per_s"]) == 1.0


class TestTheBandGoesAlong:
    """Rules 11 and 12 keep watching a setpoint that a program moves."""

    def test_leaving_it_upwards_on_a_ramp_is_a_fault(self):
        kiln = begun(5)
        kiln.feed_all([60.0] * 3)
        assert kiln.record["fault.code"] == 11

    def test_a_leap_arms_it_anew(self):
        kiln = Kiln(controller_of("{hold: 5 s}, {to: 50 °C, at: as fast as possible}"))
        kiln.start(temperature_c=90.0)
        assert kiln.feed(90.0)["guard.in_band"] == 1
        assert kiln.order("skip")
        kiln.feed_all([90.0] * 50)
        assert (kiln.record["fault.code"], kiln.record["guard.in_band"]) == (0, 0)


class TestOrders:
    """Pause and resume, skip and jump."""

    def test_a_pause_switches_off_and_a_resume_returns_first(self):
        kiln = begun(10)
        assert kiln.order("pause")
        kiln.feed_all([30.0, 25.0, 22.0])
        assert (kiln.record["enabled"], *kiln.of_program("state", "clock")) == (0, PAUSED, 10)
        assert kiln.order("resume")
        kiln.feed(22.0)
        assert (kiln.record["enabled"], *kiln.of_program("state", "leap")) == (1, RETURNING, 1)
        kiln.feed(28.0)
        assert kiln.of_program("state", "waiting", "clock") == (RETURNING, FOR_TARGET, 10)
        kiln.feed(29.0)
        assert kiln.of_program("state", "waiting", "elapsed") == (RUNNING, NOTHING, 10)
        assert kiln.feed(30.0)["setpoint_c"] == 31.0

    def test_a_skip_goes_on_from_the_setpoint(self):
        kiln = begun(10)
        assert kiln.order("skip")
        kiln.follow(1)
        assert kiln.of_program("segment", "to_c", "leap") == (2, 30.0, 0)

    @pytest.mark.parametrize(("number", "setpoint_c"), [(1, 20.0), (2, 40.0), (3, 40.0)])
    def test_a_jump_goes_where_the_segment_would_begin(self, number, setpoint_c):
        kiln = begun(10)
        assert kiln.order("jump", number)
        kiln.feed(30.0)
        assert kiln.of_program("state", "segment", "setpoint_c", "leap") \
            == (RETURNING, number, setpoint_c, 1)  # fmt: skip

    def test_a_jump_while_paused_stays_paused(self):
        kiln = begun()
        assert kiln.order("pause")
        kiln.feed(20.0)
        assert kiln.order("jump", 3)
        kiln.feed(20.0)
        assert kiln.of_program("state", "segment") == (PAUSED, 3)

    def test_a_stop_ends_it_in_every_state(self):
        for orders in ((), ("pause",), ("pause", "resume")):
            kiln = begun()
            for order in orders:
                assert kiln.order(order)
                kiln.feed(20.0)
            assert kiln.order("stop")
            kiln.miss()  # it does not wait for a reading
            assert (*kiln.of_program("state", "ended"), kiln.record["enabled"]) \
                == (IDLE, STOPPED, 0)  # fmt: skip

    @pytest.mark.parametrize(
        "order", [("pause",), ("resume",), ("skip",), ("jump", 1), ("stop",), ("start", 3)]
    )
    def test_idle_there_is_nothing_to_order(self, order):
        assert not Kiln().order(*order)

    def test_running_some_do_not_fit(self):
        kiln = begun()
        for order in (("start", 1), ("resume",), ("jump", 0), ("jump", 4)):
            assert not kiln.order(*order)

    def test_a_start_waits_for_a_reading_and_the_last_order_counts(self, kiln):
        assert kiln.order("start", 1)
        kiln.miss()
        assert kiln.of_program("state", "order") == (IDLE, 0)
        assert kiln.order("start", 2)
        kiln.feed(33.0)
        assert kiln.of_program("state", "number", "first_c") == (RUNNING, 2, 33.0)

    def test_a_start_that_waits_can_be_stopped(self, kiln):
        assert kiln.order("start", 1)
        kiln.operator.disable()
        assert not kiln.order("start", 1)
        kiln.feed(20.0)
        assert kiln.of_program("state", "order") == (IDLE, 1)

    def test_an_empty_place_starts_nothing(self, kiln):
        assert kiln.order("start", 1)
        assert not kiln.order("start", 3)
        kiln.feed(20.0)
        assert kiln.of_program("state", "order") == (IDLE, 0)

    def test_a_program_keeps_the_loop_to_itself(self):
        kiln = begun()
        operator = kiln.operator
        assert not operator.set(500.0)
        assert not operator.enable()
        assert not operator.set_manual(50.0)
        assert operator.set_gains(2.0, None, None)
        operator.disable()
        kiln.feed(20.0)
        assert kiln.of_program("state", "ended") == (IDLE, STOPPED)

    def test_after_it_the_loop_can_be_switched_on_at_once(self):
        kiln = begun()
        assert kiln.order("stop")
        kiln.feed(20.0)
        assert kiln.operator.set(80.0)
        assert kiln.operator.enable()
        assert kiln.feed(20.0)["duty_percent"] > 0


class TestFaults:
    """A fault ends a program; nothing but a start begins it again."""

    def test_an_acknowledgement_before_the_next_step_ends_it_too(self):
        kiln = begun()
        kiln.feed(1100.0)
        assert (kiln.record["fault.code"], *kiln.of_program("state")) == (6, RUNNING)
        kiln.operator.acknowledge()
        kiln.feed(25.0)
        assert (kiln.record["fault.code"], *kiln.of_program("state", "ended")) == (0, IDLE, FAILED)
        assert kiln.record["enabled"] == 0

    def test_with_one_latched_nothing_starts(self, kiln):
        kiln.feed(1100.0)
        assert not kiln.order("start", 1)

    def test_one_that_comes_first_drops_an_order(self):
        kiln = begun()
        assert kiln.order("pause")
        kiln.reference.stop()
        kiln.feed(20.0)
        assert kiln.of_program("state", "order", "ended") == (IDLE, 0, FAILED)
