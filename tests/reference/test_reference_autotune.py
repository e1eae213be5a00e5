"""The relay experiment, step by step."""

import pytest
from reference_commanded import Commanded, controller_of

from heatwright.sim.reference.inputs import AUTOMATIC

RUNNING, DONE, TIMED_OUT, STOPPED, TOO_HOT, NO_USE = 1, 2, 3, 4, 5, 6
TARGET_C = 80.0
LOOSE = "frozen: off, rise_rate: 100 K/s, heating: off, runaway: off, rising_while_off: off"


@pytest.fixture
def loop():
    loop = Commanded(controller_of(protection=LOOSE))
    loop.feed(25.0)
    loop.tune(TARGET_C)
    return loop


def member(records, name):
    return [float(record[f"autotune.{name}"]) for record in records]


def swing(rise_k=2.0, fall_k=1.0, top_c=85.0, bottom_c=75.0):
    """Up at one slope, down at another."""
    up = [bottom_c + n * rise_k for n in range(round((top_c - bottom_c) / rise_k))]
    return up + [top_c - n * fall_k for n in range(round((top_c - bottom_c) / fall_k))]


def heat_up(loop):
    return loop.feed_all([25.0 + 2.5 * n for n in range(23)])  # to 80 °C


def test_it_heats_from_cold_and_measures_the_slope(loop):
    records = heat_up(loop)
    assert member(records, "phase") == [1] * 18 + [2] * 4 + [3]
    assert [r["duty_percent"] for r in records] == [100] * 22 + [0]
    # from between 67.5 and 70 °C to between 77.5 and 80 °C, in four steps
    assert member(records, "from_c")[-1] == 68.75
    assert member(records, "rise")[-1] == 2.5


def test_a_hot_machine_cools_first():
    loop = Commanded(controller_of(protection=LOOSE))
    loop.feed(105.0)
    loop.tune(TARGET_C)
    records = loop.feed_all([105.0, 90.0, 70.0, 60.0625, 60.0, 60.0])
    assert member(records, "phase") == [0, 0, 0, 0, 1, 1]
    assert [r["duty_percent"] for r in records] == [0, 0, 0, 0, 100, 100]
    assert set(member(records, "result")) == {RUNNING}


@pytest.mark.parametrize(("top_c", "width_k"), [(80.5, 1), (83.0, 3), (95.0, 5)])
def test_the_first_overshoot_sets_the_width(loop, top_c, width_k):
    heat_up(loop)
    records = loop.feed_all([top_c, 79.0625, 79.0])
    assert member(records, "phase") == [3, 3, 4]
    assert member(records, "hysteresis_k") == [0, 0, width_k]


def test_the_relay_switches_on_what_it_reads(loop):
    heat_up(loop)
    loop.feed_all([83.0, 79.0])
    records = loop.feed_all([77.0625, 77.0, 76.0, 82.9375, 83.0, 84.0, 77.0])
    assert [r["duty_percent"] for r in records] == [0, 100, 100, 100, 0, 0, 100]
    assert member(records, "switches") == [0, 1, 1, 1, 1, 1, 2]
    assert member(records, "on_steps")[4] == 3
    assert member(records, "high_c")[4] == (82.9375 + 83) / 2
    assert member(records, "peak_c")[5] == 84


def tuned(loop, cycles=5, **shape):
    loop.tune(TARGET_C, cycles)
    heat_up(loop)
    loop.feed_all([85.0, 79.0])
    return [r for _ in range(cycles + 1) for r in loop.feed_all([*swing(**shape), 75.0, 74.0])]


def test_it_ends_after_the_cycles_asked_for(loop):
    records = tuned(loop)
    assert member(records, "result")[-1] == DONE
    last = member(records, "result").index(DONE)
    assert member(records, "switches")[last] == 6
    assert {float(r["duty_percent"]) for r in records[last:]} == {0}
    assert all(gain > 0 for gain in loop.tuner.gains)


def test_the_first_swing_does_not_count(loop):
    records = tuned(loop)
    sums = sorted(set(member(records, "on_sum")))
    assert len(sums) == 5  # none, and four swings
    assert len(set(member(records, "swing_sum"))) == 5


@pytest.mark.parametrize(("asked", "done"), [(0, 3), (3, 3), (7, 7), (200, 20), (None, 5)])
def test_cycles_are_limited(loop, asked, done):
    loop.tune(TARGET_C, asked)
    assert loop.feed(25.0)["autotune.cycles"] == done


def test_too_hot(loop):
    heat_up(loop)
    records = loop.feed_all([99.9375, 100.0])
    assert member(records, "result") == [RUNNING, TOO_HOT]
    assert records[-1]["duty_percent"] == 0


def test_time_out():
    loop = Commanded(controller_of(loop="autotune: {timeout: 5 s}", protection=LOOSE))
    loop.tune(TARGET_C)
    records = loop.feed_all([25.0] * 6)
    assert member(records, "result") == [RUNNING] * 4 + [TIMED_OUT] * 2
    assert [r["duty_percent"] for r in records] == [100] * 4 + [0] * 2


def test_time_goes_on_without_readings():
    loop = Commanded(controller_of(loop="autotune: {timeout: 5 s}", protection=LOOSE))
    loop.tune(TARGET_C)
    records = [loop.feed(25.0), *(loop.miss() for _ in range(3)), loop.feed(25.0)]
    assert member(records, "steps") == [1, 2, 3, 4, 5]
    assert [r["duty_percent"] for r in records] == [100, 0, 0, 0, 0]
    assert member(records, "result")[-1] == TIMED_OUT


def test_another_mode_stops_it(loop):
    loop.feed(25.0)
    loop.mode = AUTOMATIC
    assert loop.feed(25.0)["autotune.result"] == STOPPED


def test_a_fault_stops_it(loop):
    loop.feed(25.0)
    loop.reference.stop()
    record = loop.feed(25.0)
    assert (record["autotune.result"], record["duty_percent"]) == (STOPPED, 0)


def test_without_readings_for_long_a_fault_stops_it(loop):
    loop.feed(25.0)
    records = [loop.miss() for _ in range(5)]
    assert records[-1]["fault.code"] == 1
    assert records[-1]["autotune.result"] == STOPPED


def test_a_new_start_forgets_the_old_one(loop):
    heat_up(loop)
    loop.tune(TARGET_C)
    record = loop.feed(25.0)
    assert (record["autotune.starts"], record["autotune.result"]) == (2, RUNNING)
    assert (record["autotune.steps"], record["autotune.rise"]) == (1, 0)


def test_a_slope_that_is_none_is_no_use(loop):
    """A reading that falls and jumps on the way to the target."""
    loop.feed_all([60.0, 75.0, 40.0, 80.0])
    loop.feed_all([85.0, 79.0])
    records = [r for _ in range(6) for r in loop.feed_all([*swing(), 75.0, 74.0])]
    assert member(records, "rise")[-1] == -3.75
    assert member(records, "result")[-1] == NO_USE
    assert not any(loop.tuner.gains)


def test_less_swing_heats_less():
    loop = Commanded(controller_of(loop="autotune: {swing: 60 %}", protection=LOOSE))
    loop.tune(TARGET_C)
    assert loop.feed(25.0)["duty_percent"] == 60


def test_full_power_of_a_small_swing_must_show_too():
    rules = "frozen: off, heating: {rise: 2 K, within: 4 s}"
    loop = Commanded(controller_of(loop="autotune: {swing: 60 %}", protection=rules))
    loop.tune(TARGET_C)
    assert [r["fault.code"] for r in loop.feed_all([25.0] * 5)] == [0, 0, 0, 0, 10]


def test_the_band_is_not_watched_until_the_target_is_reached():
    rules = (
        "frozen: off, heating: off, rise_rate: 100 K/s, runaway: {above: 5 K, below: 5 K, for: 3 s}"
    )
    loop = Commanded(controller_of(protection=rules))
    loop.feed(80.0)
    loop.tune(TARGET_C)
    assert {r["fault.code"] for r in loop.feed_all([80.0, 70.0, 65.0, 60.0, 59.0])} == {0}
    assert {r["fault.code"] for r in loop.feed_all([60.0, 65.0, 70.0, 75.0, 80.0, 79.0])} == {0}
    assert [r["fault.code"] for r in loop.feed_all([74.0] * 3)] == [0, 0, 12]


def test_a_loop_without_autotune_has_none_of_it():
    reference = Commanded(controller_of(loop="ready_within: 1 K")).reference
    assert not [name for name, _ in reference.members if name.startswith("autotune")]
    assert reference.steering.tuner is None
