"""A commanded loop's log replays, and nothing else does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import events, example

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.replay import ReplayError, replay

SAID = {
    1: "M104 S60",
    12: "M104 D30",
    15: "M104 D",
    18: "M104 S62",
    21: "M301 P5 I0.1 D20",
    24: "M112",
    25: "M104 S80",
    27: "M999",
    28: "M303 S70 C3",
    45: "M104 S60",
    50: "M303 S70",
    52: "M108",
    53.01: "M112",
    53.02: "M999",
    54.01: "M303 S70",
    54.02: "M104 S0",
    54.03: "M303 S70 C4",
}
INPUTS = {"reading_raw", "mode", "manual_percent", "autotune.starts", "autotune.cycles"}
"""What a flipped bit may leave without a difference."""


@pytest.fixture(scope="module")
def log():
    device = ReferenceDevice(example("extruder"))
    lines = [{"at": f"{time_s} s", "send": line} for time_s, line in SAID.items()]
    return bench(example("extruder"), device, events(*lines, {"for": "80 s"})).steps["nozzle"]


def test_every_mode_occurs(log):
    assert set(log["mode"]) == {0, 1, 2}
    assert {0, 1, 4} <= set(log["autotune.result"])
    assert set(log["fault.code"]) == {0, 19}
    assert log["fault.acknowledgements"][-1] == 2
    assert log["autotune.starts"][-1] == 4


def test_its_own_steps_are_equal(log):
    result = replay(example("extruder"), log)
    assert (result.ticks, result.mismatches, result.segments) == (len(log), 0, 1)
    assert result.first == result.restored == result.unchecked == ()


def test_two_resets_are_three_runs(log):
    result = replay(example("extruder"), np.concatenate([log, log, log[:300]]))
    assert (result.mismatches, result.segments) == (0, 3)


@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_any_flipped_bit_of_what_follows_is_seen(log, data):
    row = data.draw(st.integers(1, len(log) - 1))
    gains = {f"algorithm.{gain}" for gain in ("kp", "ki", "kd")}
    names = set(log.dtype.names) - {"time_s", "setpoint_c", "reading_status", *INPUTS, *gains}
    member = data.draw(st.sampled_from(sorted(names)))
    broken = log[: row + 20].copy()
    cell = broken[member][row : row + 1].view(np.uint8)
    bit = data.draw(st.integers(0, 8 * len(cell) - 1))
    cell[bit // 8] ^= 1 << bit % 8
    assert replay(example("extruder"), broken).mismatches


@pytest.mark.parametrize("gain", ["kp", "ki", "kd"])
def test_gains_that_changed_show_in_what_follows(log, gain):
    free = (log["duty_percent"] > 0) & (log["duty_percent"] < 100) & (log["mode"] == 0)
    inside = (log["algorithm.integral"] > 23.5) & (log["algorithm.integral"] < 58.8)
    row = int(np.flatnonzero(free & inside)[3])
    broken = log.copy()
    broken[f"algorithm.{gain}"][row] *= 2
    found = replay(example("extruder"), broken)
    assert found.mismatches
    assert found.first[0].row in {row, row + 1}


def test_a_tuning_without_its_start_is_seen(log):
    row = int(np.flatnonzero(np.diff(log["autotune.starts"]))[0]) + 1
    broken = log[: row + 5].copy()
    broken["autotune.starts"][row:] -= 1
    assert replay(example("extruder"), broken).mismatches


def test_a_log_must_have_the_inputs(log):
    names = [name for name in log.dtype.names if name != "mode"]
    with pytest.raises(ReplayError, match="lacks mode"):
        replay(example("extruder"), log[names])
