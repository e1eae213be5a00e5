"""The replay accepts what the equations give, and nothing else, whoever commands the loop."""

import dataclasses

import numpy as np
import pytest
from bench_runs import written
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import at, events, example, modelled

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.reference import Reference
from heatwright.sim.reference.copies import copy_of
from heatwright.sim.reference.inputs import Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.program_state import (
    PAUSED,
    RESTORING,
    RETURNING,
    RUNNING,
    ProgramState,
)
from heatwright.sim.replay import ReplayError, replay
from heatwright.spec import Pid

COMMANDED = at(
    {
        1: "M104 S60", 12: "M104 D30", 15: "M104 D", 18: "M104 S62", 21: "M301 P5 I0.1 D20",
        24: "M112", 25: "M104 S80", 27: "M999", 28: "M303 S70 C3", 45: "M104 S60",
        50: "M303 S70", 52: "M108", 53.01: "M112", 53.02: "M999", 54.01: "M303 S70",
        54.02: "M104 S0", 54.03: "M303 S70 C4",
    }
)  # fmt: skip
SWITCHED = (
    written(1, nozzle__setpoint="60 °C", nozzle__enabled=True),
    written(20, nozzle__setpoint="30 °C"),
    written(40, nozzle__setpoint="300 °C"),
    written(50, nozzle__enabled=False),
)
PROGRAMMED = at(
    {
        5: "#3 30;", 6: "#2 1;", 12: "#2 0;", 15: "#8 1;", 28: "#18;", 30: "#9 0;", 33: "#9 1;",
        45: "#10 3;", 60: "#5 5;#6 0.05;",
        61: "#20 25;",  # below the kiln, which is at some 27 °C by then
        69: "#20 900;", 70: "#16;", 73: "#8 1;", 90: "#17;",
    }
)  # fmt: skip
TOLD = {
    "extruder": (*COMMANDED, {"for": "80 s"}),
    "fabricator": (*SWITCHED, {"for": "55 s"}),
    "kiln": (*PROGRAMMED, {"for": "100 s"}),
}
LOGS = ("chamber", *TOLD)
OCCUR = {
    "chamber": {"fault.code": {0, 8}},
    "extruder": {
        "mode": {0, 1, 2}, "fault.code": {0, 19}, "autotune.starts": {0, 1, 2, 4},
        "fault.acknowledgements": {0, 1, 2},
    },
    "fabricator": {"cooling": {0, 1}, "algorithm.cooling": {0, 1}, "enabled": {0, 1}},
    "kiln": {
        "program.state": {0, 1, 2, 3}, "program.ended": {0, 2, 3}, "fault.code": {0, 6},
        "program.order": {0, 1, 2, 3, 4, 5, 6}, "guard.maximum_c": {1150.0, 25.0, 900.0},
    },
}  # fmt: skip
SOME_OCCUR = {
    "extruder": {"autotune.result": {0, 1, 4}},
    "fabricator": {"duty_percent": {0, 25, 50, 75, 100}},
}
INPUTS = {"reading_status", "reading_raw", "fault.acknowledgements"}
"""What the replay takes from the log; that it is wrong shows in what follows from it."""
GAINS = {f"algorithm.{gain}" for gain in ("kp", "ki", "kd")}
FREE = {
    "extruder": {"mode", "manual_percent", "autotune.starts", "autotune.cycles", *GAINS},
    "fabricator": {"enabled", "current.raw"},
    "kiln": {
        "mode", "manual_percent", "enabled", "loaded", "program.order", "program.argument",
        "guard.maximum_c", *GAINS,
    },
}  # fmt: skip
"""What a flipped bit may leave without a difference, besides the reading: orders, and what they
set. The setpoint is the operator's: while a fault is latched nothing follows from it."""
NEEDED = {
    "chamber": ("missing",),
    "extruder": ("mode",),
    "fabricator": ("enabled", "current.raw", "cooling"),
    "kiln": ("loaded", "program.leap", "guard.maximum_c", "reading_c"),
}


@pytest.fixture(scope="module")
def controllers(vary):
    gains = {"kp": 11.3, "ki": 0.07, "kd": 100, "derivative_filter": "3 s"}
    chamber = vary(algorithm=Pid.model_validate({"kind": "pid", **gains}))
    return {"chamber": chamber} | {name: example(name) for name in TOLD}


@pytest.fixture(scope="module")
def logs(controllers):
    """What the models do; the chamber: heating up, a jump, an acknowledgement."""
    device = ReferenceDevice(controllers["chamber"])
    bench(controllers["chamber"], device, events({"at": "5 s", "press": "up"}, {"for": "60 s"}))
    device.sense("air", 60.0)
    device.advance(65.0)
    device.sense("air", 30.0)
    device.press("select")
    device.advance(70.0)
    told = {name: modelled(name, *lines).log for name, lines in TOLD.items()}
    return {"chamber": device.steps("air")} | told


@pytest.fixture(scope="module")
def controller(controllers):
    return controllers["chamber"]


@pytest.fixture(scope="module")
def log(logs):
    return logs["chamber"]


@pytest.mark.parametrize("name", LOGS)
def test_its_own_steps_are_equal(controllers, logs, name):
    result = replay(controllers[name], logs[name])
    assert (result.ticks, result.mismatches, result.segments) == (len(logs[name]), 0, 1)
    assert result.first == result.restored == result.unchecked == ()
    for member, wanted in OCCUR[name].items():
        assert set(logs[name][member]) == wanted
    for member, wanted in SOME_OCCUR.get(name, {}).items():
        assert set(logs[name][member]) >= wanted


@pytest.mark.parametrize("name", LOGS)
def test_two_resets_are_three_runs(controllers, logs, name):
    log = logs[name]
    result = replay(controllers[name], np.concatenate([log, log, log[: min(300, len(log))]]))
    assert (result.mismatches, result.segments) == (0, 3)


def flipped(log, data, least_row, free):
    """A log with one bit of one member wrong; the row and the member."""
    row = data.draw(st.integers(least_row, len(log) - 1))
    member = data.draw(
        st.sampled_from(sorted({*log.dtype.names} - {"time_s", "setpoint_c"} - free))
    )
    broken = log.copy()
    cell = broken[member][row : row + 1].view(np.uint8)
    bit = data.draw(st.integers(0, 8 * len(cell) - 1))
    cell[bit // 8] ^= 1 << bit % 8
    return broken, row, member


@given(data=st.data())
@settings(max_examples=200)
def test_any_flipped_bit_is_seen_in_its_step(controller, log, data):
    broken, row, member = flipped(log, data, 0, set())
    result = replay(controller, broken)
    assert result.mismatches or result.restored
    restored = row == 0 and member == "fault.temperature_c"  # where a run begins, it is an input
    if member not in INPUTS and result.first and not restored:
        assert result.first[0].row == row


@pytest.mark.parametrize("name", TOLD)
@given(data=st.data())
@settings(max_examples=100)
def test_any_flipped_bit_of_what_follows_is_seen(logs, name, data):
    free = FREE[name] | {"reading_raw", "reading_status"}
    broken, row, _ = flipped(logs[name], data, 1, free)
    assert replay(example(name), broken[: row + 20]).mismatches


@pytest.mark.parametrize(("name", "member"), [(name, m) for name in LOGS for m in NEEDED[name]])
def test_a_log_must_have_what_is_needed(controllers, logs, name, member):
    names = [each for each in logs[name].dtype.names if each != member]
    with pytest.raises(ReplayError, match=f"lacks {member}"):
        replay(controllers[name], logs[name][names])


def test_a_log_must_have_steps_and_its_types(controller, log):
    with pytest.raises(ReplayError, match="no control steps"):
        replay(controller, log[:0])
    double = log.astype(
        [(n, "f8" if n == "duty_percent" else log.dtype[n]) for n in log.dtype.names]
    )
    with pytest.raises(ReplayError, match="duty_percent is float64 in the log, not float32"):
        replay(controller, double)


@pytest.mark.parametrize("row", [0, 20, -2])
def test_a_missing_step_is_seen(controller, log, row):
    assert replay(controller, np.delete(log, row)).mismatches


@pytest.mark.parametrize("row", [1, 20, -1])
def test_a_repeated_step_is_seen(controller, log, row):
    assert replay(controller, np.insert(log, row, log[row])).mismatches


def test_the_first_step_done_twice_is_a_reset_that_shows(controller, log):
    assert replay(controller, np.insert(log, 0, log[0])).segments == 2


def test_a_fault_that_outlived_a_reset_is_listed(controller, log):
    """After the reset the fault is there, although the reading gives no reason for it."""
    after = log[:4].copy()
    for name in after.dtype.names:
        if name.startswith(("algorithm.", "guard.")):
            after[name] = 0
    values = {"fault.code": 6, "fault.temperature_c": 91.5, "fault.acknowledgements": 0}
    for name, value in {**values, "duty_percent": 0, "guard.fresh": 1}.items():
        after[name] = value
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
    broken["duty_percent"][int(np.flatnonzero(broken["duty_percent"] == 0)[0])] = -0.0
    assert replay(controller, broken).mismatches == 1


def test_members_that_the_reference_lacks_are_named(controller, log):
    wider = np.zeros(len(log), [*log.dtype.descr, ("fault.time_s", "u4")])
    for name in log.dtype.names:
        wider[name] = log[name]
    assert replay(controller, wider).unchecked == ("fault.time_s",)


# ---- a host: gains and tunings are told by what follows ----


@pytest.mark.parametrize("gain", ["kp", "ki", "kd"])
def test_gains_that_changed_show_in_what_follows(logs, gain):
    log = logs["extruder"]
    free = (log["duty_percent"] > 0) & (log["duty_percent"] < 100) & (log["mode"] == 0)
    inside = (log["algorithm.integral"] > 23.5) & (log["algorithm.integral"] < 58.8)
    row = int(np.flatnonzero(free & inside)[3])
    broken = log.copy()
    broken[f"algorithm.{gain}"][row] *= 2
    found = replay(example("extruder"), broken)
    assert found.mismatches
    assert found.first[0].row in {row, row + 1}


def test_a_tuning_without_its_start_is_seen(logs):
    log = logs["extruder"]
    row = int(np.flatnonzero(np.diff(log["autotune.starts"]))[0]) + 1
    broken = log[: row + 5].copy()
    broken["autotune.starts"][row:] -= 1
    assert replay(example("extruder"), broken).mismatches


# ---- a master: its silence ----


def test_a_lost_master_does_not_explain_a_fault_of_a_loop_that_is_off(logs):
    log = logs["fabricator"]
    row = int(np.flatnonzero((log["enabled"] == 0) & (log["steps"] > 10))[0])
    broken = log[: row + 1].copy()
    broken["fault.code"][row] = 23
    broken["fault.temperature_c"][row] = broken["temperature_c"][row]
    broken["cooling"][row] = broken["temperature_c"][row] >= 50
    assert replay(example("fabricator"), broken).mismatches


# ---- programs: copies, and what outlives a reset ----


def test_another_copy_of_the_program_is_another_firing(logs):
    broken = logs["kiln"].copy()
    broken["loaded"]["segment"]["amount"][:, 0] += 60
    assert replay(example("kiln"), broken).mismatches


def after_a_reset(log, state, feed_c, *, code=0, relay=False):
    """The steps of a model that lost its power in the last step of a log."""
    kiln = example("kiln")
    reference = Reference(kiln, "chamber")
    found = log[np.flatnonzero(log["program.state"] == RUNNING)[10]]
    members = {name: found[f"program.{name}"] for name in ProgramState.__dataclass_fields__}
    before = ProgramState(
        **{name: value if value.dtype == "f4" else int(value) for name, value in members.items()}
    )
    rest = {"state": state, "waiting": 0, "leap": 0, "order": 0, "rate_k_per_s": Single(0)}
    reference.program.load(1, copy_of(kiln.programs.stored[0]))
    reference.program.restore(dataclasses.replace(before, argument=0, before_c=Single(27), **rest))
    if code and not relay:
        reference.restore(code, Single(3))
    gains = Gains(*(Single(found[f"algorithm.{name}"]) for name in Gains._fields))
    rows = []
    for number in range(30):
        relay_fault = code if relay else 0
        orders = Orders(gains=gains, enabled=0, maximum_c=Single(1150), relay_fault=relay_fault)
        status = 1 if number < 1 and feed_c is None else 0
        raw = 0 if status else round((feed_c or 27.0) * 128)
        step = reference.step(status, raw, Single(20), orders=orders)
        rows.append((float(number), *step.values()))
    kept = np.empty(len(rows), log.dtype)
    plain = np.array(rows, [("time_s", "f8"), *reference.members])
    for name in plain.dtype.names:
        kept[name] = plain[name]
    kept["loaded"] = log["loaded"][-1]
    return kept


def replayed_after(logs, *given, **more):
    """What the replay says of the kiln's log and such steps behind it, and these."""
    after = after_a_reset(logs["kiln"], *given, **more)
    return replay(example("kiln"), np.concatenate([logs["kiln"], after])), after


@pytest.mark.parametrize("state", [RESTORING, PAUSED])
@pytest.mark.parametrize("feed_c", [27.0, 100.0, None])
def test_a_program_that_outlived_a_reset_is_followed(logs, state, feed_c):
    result, after = replayed_after(logs, state, feed_c)
    assert (result.mismatches, result.segments, result.restored) == (0, 2, ())
    if state == RESTORING and feed_c != 100.0:
        assert RETURNING in after["program.state"]


@pytest.mark.parametrize(("code", "relay", "restored"), [(6, 0, [6]), (25, 0, [25]), (25, 1, [])])
def test_with_a_fault_that_outlived_it_too(logs, code, relay, restored):
    """A relay that fails in the first step is no such fault."""
    result, _ = replayed_after(logs, RESTORING, 27.0, code=code, relay=relay)
    assert (result.mismatches, [each.fault_code for each in result.restored]) == (0, restored)
