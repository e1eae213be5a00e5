"""The replay accepts what the equations give, and nothing else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.replay import ReplayError, replay
from heatwright.spec import Event, Pid

INPUTS = {"reading_status", "reading_raw"}


@pytest.fixture(scope="module")
def controller(vary):
    pid = Pid.model_validate(
        {"kind": "pid", "kp": 11.3, "ki": 0.07, "kd": 100, "derivative_filter": "3 s"}
    )
    return vary(algorithm=pid)


@pytest.fixture(scope="module")
def log(controller):
    """Heating up, a jump, an acknowledgement."""
    device = ReferenceDevice(controller)
    scenario = [
        Event.model_validate(line) for line in ({"at": "5 s", "press": "up"}, {"for": "60 s"})
    ]
    bench(controller, device, scenario)
    device.sense("air", 60.0)
    device.advance(65.0)
    device.sense("air", 30.0)
    device.press("select")
    device.advance(70.0)
    rows = device.steps("air")
    assert set(rows["fault.code"]) == {0, 8}
    return rows


def test_its_own_steps_are_equal(controller, log):
    result = replay(controller, log)
    assert (result.ticks, result.mismatches, result.segments) == (len(log), 0, 1)
    assert result.first == result.restored == result.unchecked == ()


# The setpoint is the operator's: while a fault is latched nothing follows from it.
@given(data=st.data())
@settings(deadline=None, max_examples=200)
def test_any_flipped_bit_is_seen(controller, log, data):
    row = data.draw(st.integers(0, len(log) - 1))
    member = data.draw(
        st.sampled_from([n for n in log.dtype.names if n not in {"time_s", "setpoint_c"}])
    )
    broken = log.copy()
    cell = broken[member][row : row + 1].view(np.uint8)
    bit = data.draw(st.integers(0, 8 * len(cell) - 1))
    cell[bit // 8] ^= 1 << bit % 8
    result = replay(controller, broken)
    assert result.mismatches or result.restored
    restored = row == 0 and member == "fault.temperature_c"  # where a run begins, it is an input
    if member not in INPUTS and result.first and not restored:
        assert result.first[0].row == row


@pytest.mark.parametrize("row", [0, 20, -2])
def test_a_missing_step_is_seen(controller, log, row):
    assert replay(controller, np.delete(log, row)).mismatches


@pytest.mark.parametrize("row", [1, 20, -1])
def test_a_repeated_step_is_seen(controller, log, row):
    assert replay(controller, np.insert(log, row, log[row])).mismatches


def test_a_reset_begins_a_segment(controller, log):
    result = replay(controller, np.concatenate([log, log, log[:3]]))
    assert (result.mismatches, result.segments) == (0, 3)


def test_the_first_step_done_twice_is_a_reset_that_shows(controller, log):
    assert replay(controller, np.insert(log, 0, log[0])).segments == 2


def test_a_fault_that_outlived_a_reset_is_listed(controller, log):
    """After the reset the fault is there, although the reading gives no reason for it."""
    after = log[:4].copy()
    after["fault.code"] = 6
    after["fault.temperature_c"] = 91.5
    after["fault.acknowledgements"] = 0
    after["duty_percent"] = 0
    for name in after.dtype.names:
        if name.startswith("algorithm."):
            after[name] = 0
        if name.startswith("guard."):
            after[name] = 0
    after["guard.fresh"] = 1
    result = replay(controller, np.concatenate([log, after]))
    assert result.mismatches == 0
    assert [(found.row, found.fault_code) for found in result.restored] == [(len(log), 6)]


def test_the_temperature_of_an_acknowledged_fault_outlives_a_reset(controller, log):
    after = log[:4].copy()
    after["fault.temperature_c"] = 91.5
    result = replay(controller, np.concatenate([log, after]))
    assert (result.mismatches, result.segments, result.restored) == (0, 2, ())


def test_a_mismatch_says_what_and_where(controller, log):
    broken = log.copy()
    broken["duty_percent"][10] = np.nextafter(broken["duty_percent"][10], np.float32(0))
    (found,) = replay(controller, broken).first
    assert (found.row, found.time_s, found.variable) == (10, 11.0, "duty_percent")
    assert "0x" in str(found)
    assert "step 10 at 11.000 s: duty_percent is " in str(found)


def test_minus_zero_is_not_zero(controller, log):
    broken = log.copy()
    row = int(np.flatnonzero(broken["duty_percent"] == 0)[0])
    broken["duty_percent"][row] = -0.0
    assert replay(controller, broken).mismatches == 1


def test_members_that_the_reference_lacks_are_named(controller, log):
    wider = np.zeros(len(log), [*log.dtype.descr, ("fault.time_s", "u4")])
    for name in log.dtype.names:
        wider[name] = log[name]
    assert replay(controller, wider).unchecked == ("fault.time_s",)


def test_a_log_must_be_complete(controller, log):
    with pytest.raises(ReplayError, match="no control steps"):
        replay(controller, log[:0])
    names = [name for name in log.dtype.names if name != "missing"]
    with pytest.raises(ReplayError, match="lacks missing"):
        replay(controller, log[names])
    double = log.astype(
        [(n, "f8" if n == "duty_percent" else log.dtype[n]) for n in log.dtype.names]
    )
    with pytest.raises(ReplayError, match="duty_percent is float64 in the log, not float32"):
        replay(controller, double)
