"""Every rule trips exactly at its bound, and not one step or one sensor step before."""

from itertools import chain, repeat

import pytest
from player import Player

from heatwright.sim.reference import guard, guard_rules
from heatwright.spec import Frozen, Heating, OnOff, Pid, RisingWhileOff, Runaway
from heatwright.spec.rules import RULES

OFF = {"heating": None, "runaway": None, "frozen": None, "rising_while_off": None}
STEP = 0.0625


def saw(centre_c: float, count: int) -> list[float]:
    """A reading that moves by one sensor step, so that it is not frozen."""
    return [centre_c + STEP * (number % 2) for number in range(count)]


def test_over_temperature_at_the_maximum_and_not_below(vary):
    player = Player(vary(**OFF, maximum_c=85.0))
    assert player.feed(85.0 - STEP)["fault.code"] == 0
    record = player.feed(85.0)
    assert record["fault.code"] == 6
    assert record["fault.temperature_c"] == 85.0
    assert record["duty_percent"] == 0


def test_under_temperature_at_the_minimum_and_not_above(vary):
    player = Player(vary(**OFF, minimum_c=-10.0))
    assert player.feed(-10.0 + STEP)["fault.code"] == 0
    assert player.feed(-10.0)["fault.code"] == 7


@pytest.mark.parametrize("sign", [1, -1])
def test_jump_must_be_more_than_the_rate_allows(vary, sign):
    player = Player(vary(**OFF, rise_rate_k_per_s=5.0))
    player.feed(30.0)
    assert player.feed(30.0 + sign * 5.0)["fault.code"] == 0
    assert player.feed(30.0 + sign * (10.0 + STEP))["fault.code"] == 8


def test_jump_after_missing_readings_may_be_as_much_larger(vary):
    player = Player(vary(**OFF, rise_rate_k_per_s=5.0))
    player.feed(30.0)
    player.miss()
    player.miss()
    assert player.feed(45.0)["fault.code"] == 0
    player.miss()
    assert player.feed(55.0 + STEP)["fault.code"] == 8


def test_first_reading_is_never_a_jump(vary):
    player = Player(vary(**OFF))
    assert player.miss()["has_reading"] == 0
    assert player.feed(70.0)["fault.code"] == 0


def test_first_reading_after_many_missing_is_not_a_jump_either(vary):
    player = Player(vary(**OFF, stale_after_s=1000.0))
    for _ in range(200):
        player.miss()
    record = player.feed(70.0)
    assert record["fault.code"] == 0
    assert record["missing"] == 0


@pytest.mark.parametrize("status", [1, 2, 3, 4, 5])
def test_missing_readings_become_a_fault_of_their_own_kind(vary, status):
    player = Player(vary(**OFF, stale_after_s=5.0))
    player.feed(30.0)
    for _ in range(4):
        record = player.miss(status)
        assert record["fault.code"] == 0
        assert record["duty_percent"] == 0
    record = player.miss(status)
    assert record["fault.code"] == status
    assert record["fault.temperature_c"] == 30.0


def test_a_good_reading_in_between_clears_the_missing_ones(vary):
    player = Player(vary(**OFF, stale_after_s=5.0))
    for _ in range(10):
        for _ in range(4):
            assert player.miss()["fault.code"] == 0
        assert player.feed(30.0)["missing"] == 0


def test_stale_trips_even_if_asked_for_more_steps_than_can_be_counted(vary):
    player = Player(vary(**OFF, stale_after_s=1e6))
    codes = [player.miss(3)["fault.code"] for _ in range(255)]
    assert codes == [0] * 254 + [3]


def test_heating_failed_after_the_full_time_at_full_power(vary):
    player = Player(vary(**OFF | {"heating": Heating(rise="2 K", within="120 s")}))
    player.feed(20.0)  # asks for full power from now on
    assert player.steps_until_fault(saw(20.0, 200)) == 120
    assert player.reference.fault_code == 10


def test_heating_has_not_failed_if_the_rise_comes_in_the_last_step(vary):
    player = Player(vary(**OFF | {"heating": Heating(rise="2 K", within="120 s")}))
    player.feed(20.0)
    assert player.steps_until_fault([*saw(20.0, 119), 22.0, *saw(22.0, 119)]) is None
    assert player.feed(24.0 - STEP)["fault.code"] == 10


def test_heating_needs_full_power_throughout(vary):
    pid = Pid(kind="pid", kp=4.0)
    player = Player(vary(**OFF | {"heating": Heating()}, algorithm=pid))
    assert player.feed(25.0 + STEP)["duty_percent"] < 100
    assert player.steps_until_fault(repeat(25.0 + STEP, 500)) is None


def test_full_power_of_a_limited_pid_is_its_limit(vary):
    pid = Pid.model_validate({"kind": "pid", "kp": 50, "output": {"maximum": "60 %"}})
    player = Player(vary(**OFF | {"heating": Heating()}, algorithm=pid))
    assert player.feed(20.0)["duty_percent"] == 60
    assert player.steps_until_fault(saw(20.0, 200)) == 120


def runaway(vary, **limits):
    return Player(vary(**OFF | {"runaway": Runaway(**limits)}))


def test_runaway_above_needs_the_band_to_have_been_reached(vary):
    player = runaway(vary, above="10 K", **{"for": "60 s"})
    assert player.steps_until_fault(saw(64.0, 300)) is None
    assert player.feed(60.0)["guard.in_band"] == 1
    assert player.steps_until_fault(saw(60.0 + STEP, 300)) == 60
    assert player.reference.fault_code == 11


def test_runaway_must_last(vary):
    player = runaway(vary, above="10 K", **{"for": "60 s"})
    player.feed(60.0)
    assert player.steps_until_fault([*repeat(60.0 + STEP, 59), 60.0] * 5) is None


def test_runaway_below_only_where_it_is_asked_for(vary):
    player = runaway(vary, above="10 K", below="5 K", **{"for": "60 s"})
    assert player.steps_until_fault(saw(40.0, 300)) is None
    assert player.feed(45.0)["guard.in_band"] == 3
    assert player.steps_until_fault(repeat(45.0 - STEP, 300)) == 60
    assert player.reference.fault_code == 12
    player = runaway(vary, above="10 K", **{"for": "60 s"})
    assert player.feed(45.0)["guard.in_band"] == 1
    assert player.steps_until_fault(repeat(40.0, 300)) is None


def test_a_new_setpoint_disarms_runaway(vary):
    player = runaway(vary, above="10 K", **{"for": "60 s"})
    player.feed(50.0)
    player.setpoint_c = 30.0
    record = player.feed(50.0)
    assert record["guard.in_band"] == 0
    assert record["guard.setpoint_last_c"] == 30.0
    assert player.steps_until_fault(repeat(50.0, 300)) is None


def test_frozen_after_the_full_time_below_the_setpoint_with_the_heater_on(vary):
    player = Player(vary(**OFF | {"frozen": Frozen(**{"for": "600 s"})}))
    player.feed(30.0)
    assert player.steps_until_fault(repeat(30.0, 1000)) == 600
    assert player.reference.fault_code == 9


def test_one_moved_reading_is_enough_not_to_be_frozen(vary):
    player = Player(vary(**OFF | {"frozen": Frozen(**{"for": "600 s"})}))
    player.feed(30.0)
    assert player.steps_until_fault(chain(repeat(30.0, 599), repeat(30.0 + STEP, 600))) is None
    assert player.feed(30.0 + STEP)["fault.code"] == 9


def test_a_steady_reading_at_or_above_the_setpoint_is_not_frozen(vary):
    player = Player(vary(**OFF | {"frozen": Frozen()}))
    assert player.steps_until_fault(repeat(50.0, 2000)) is None


def test_rising_while_off_after_the_settling_time(vary):
    rising = RisingWhileOff(rise="10 K", settle="120 s")
    player = Player(vary(**OFF | {"rising_while_off": rising}))
    assert player.steps_until_fault(repeat(55.0, 100)) is None
    assert player.steps_until_fault(repeat(58.0, 20)) is None  # coasts up: the lowest is 58
    player.feed(56.0)  # and cools
    assert player.feed(61.0)["fault.code"] == 0
    assert player.feed(66.0 - STEP)["fault.code"] == 0
    assert player.feed(66.0)["fault.code"] == 13


def test_rising_while_off_starts_anew_when_the_heater_was_on(vary):
    player = Player(
        vary(**OFF | {"rising_while_off": RisingWhileOff()}, algorithm=OnOff(kind="on_off"))
    )
    player.feed_all(repeat(50.0, 200))
    assert player.feed(49.0)["duty_percent"] == 100
    assert player.feed(50.0)["guard.off_steps"] == 0
    assert player.feed(50.0)["guard.off_steps"] == 1


def test_an_acknowledgement_starts_the_guard_anew(vary):
    player = Player(vary())
    player.feed_all([20.0, 21.0, 22.0])
    player.feed(30.0)
    assert player.reference.fault_code == 8
    record = player.feed(30.0)
    assert record["fault.code"] == 8
    assert record["fault.temperature_c"] == 30.0
    record = player.feed(31.0, acknowledge=True)
    assert record["fault.code"] == 0
    assert record["fault.temperature_c"] == 30.0
    assert record["guard.fresh"] == 0
    assert record["guard.heating_from_c"] == 31.0
    assert record["duty_percent"] == 100


def test_the_first_fault_stays_although_worse_comes(vary):
    player = Player(vary())
    player.feed(30.0)
    player.feed(40.0)
    assert player.feed(90.0)["fault.code"] == 8
    for _ in range(10):
        assert player.miss()["fault.code"] == 8


def test_an_acknowledged_fault_that_is_still_there_trips_again(vary):
    player = Player(vary())
    player.feed(90.0)
    record = player.feed(90.0, acknowledge=True)
    assert record["fault.code"] == 6
    assert record["guard.fresh"] == 1


def test_an_acknowledgement_without_a_fault_changes_nothing(vary):
    one, other = Player(vary()), Player(vary())
    for temperature_c in (20.0, 20.5, 21.0):
        assert one.feed(temperature_c) == other.feed(temperature_c, acknowledge=True)


def test_rules_that_are_off_leave_no_members(vary):
    player = Player(vary(**OFF))
    guard = [name for name in player.feed(30.0) if name.startswith("guard.")]
    assert guard == ["guard.fresh"]


def test_the_codes_are_those_of_the_rules():
    assert {rule.id: code for code, rule in RULES.items() if 6 <= code <= 13} == {
        "over_temperature": guard.OVER_TEMPERATURE,
        "under_temperature": guard.UNDER_TEMPERATURE,
        "rise_rate": guard.RISE_RATE,
        "sensor_frozen": guard_rules.FROZEN,
        "heating_failed": guard_rules.HEATING_FAILED,
        "runaway_above": guard_rules.RUNAWAY_ABOVE,
        "runaway_below": guard_rules.RUNAWAY_BELOW,
        "rising_while_off": guard_rules.RISING_WHILE_OFF,
    }


def test_lost_readings_are_no_excuse_for_a_dead_heater(vary):
    player = Player(vary(**OFF | {"heating": Heating(rise="2 K", within="120 s")}))
    player.feed(20.0)
    for number, reading in enumerate(saw(20.0, 119)):
        if number % 10 == 9:
            assert player.miss(3)["duty_percent"] == 0
        assert player.feed(reading)["fault.code"] == 0
    assert player.feed(20.0)["fault.code"] == 10


def test_lost_readings_do_not_wake_a_frozen_sensor(vary):
    player = Player(vary(**OFF | {"frozen": Frozen(**{"for": "60 s"})}))
    player.feed(20.0)
    for number in range(59):
        if number % 7 == 6:
            player.miss(3)
        assert player.feed(20.0)["fault.code"] == 0
    assert player.feed(20.0)["fault.code"] == 9
