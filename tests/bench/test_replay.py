"""The replay accepts what the equations give, and nothing else; the binaries give just that."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import REFUSED, RUNS, at, course, events, example, modelled, run_of, written
from numpy.lib.recfunctions import append_fields
from rig.firmware import changed as changed_text
from rig.firmware import whole

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import ReplayError, replay
from heatwright.spec import Pid

COMMANDED = at(
    {
        1: "M104 S60", 3: "M301 Y60", 4: "M301 P9 Y200", 4.5: "M301 Y100", 12: "M104 D30",
        15: "M104 D", 18: "M104 S62", 21: "M301 P5 I0.1 D20", 24: "M112", 25: "M104 S80",
        27: "M999", 28: "M303 S70 C3", 45: "M104 S60", 49: "M301 J24 K25",
        50: "M303 S70", 52: "M108", 53.01: "M112", 53.02: "M999", 53.5: "M301 K40",
        54.01: "M303 S70", 54.02: "M104 S0", 54.03: "M303 S70 C4",
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
    "chamber": {"fault.code": {0, 8}, "fault.acknowledgements": {0, 1}},
    "extruder": {
        "mode": {0, 1, 2}, "fault.code": {0, 19}, "autotune.starts": {0, 1, 2, 4},
        "fault.acknowledgements": {0, 1, 2}, "autotune.result": {0, 1, 4},
        "output_maximum_percent": {100, 60}, "duty_percent": {100, 60, 0},
        "integral_maximum_percent": {np.float32(58.8), 25, 40},
    },
    "fabricator": {
        "cooling": {0, 1}, "algorithm.cooling": {0, 1}, "enabled": {0, 1},
        "duty_percent": {0, 25, 50, 75, 100},
    },
    "kiln": {
        "program.state": {0, 1, 2, 3}, "program.ended": {0, 2}, "fault.code": {0, 6},
        "program.order": {0, 3, 5, 6, 9, 10, 12}, "guard.maximum_c": {1150.0, 25.0, 900.0},
    },
}  # fmt: skip
INPUTS = {"reading_status", "reading_raw", "fault.acknowledgements"}
"""What the replay takes from the log; that it is wrong shows in what follows from it."""
GAINS = ("algorithm.kp", "algorithm.ki", "algorithm.kd")
LIMITS = ("integral_minimum_percent", "integral_maximum_percent", "output_maximum_percent")
FREE = {
    "extruder": {"mode", "manual_percent", "autotune.starts", "autotune.cycles", *GAINS, *LIMITS},
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
    device.advance(65.1)
    device.press(None)
    device.advance(70.0)
    told = {name: modelled(name, *lines).log for name, lines in TOLD.items()}
    return {"chamber": device.steps("air")} | told


@pytest.fixture(scope="module")
def replayed(controllers):
    return lambda log: replay(controllers["chamber"], log)


@pytest.fixture(scope="module")
def log(logs):
    return logs["chamber"]


def changed(log, rows, **values):
    """A log with other values in these rows; `fault__code` is the name `fault.code`."""
    broken = log.copy()
    for name, value in values.items():
        broken[name.replace("__", ".")][rows] = value
    return broken


def first_row(condition, number=0):
    return int(np.flatnonzero(condition)[number])


@pytest.mark.parametrize("name", LOGS)
def test_its_own_steps_are_equal(controllers, logs, name):
    log = logs[name]
    result = replay(controllers[name], log)
    assert (result.ticks, result.mismatches, result.segments) == (len(log), 0, 1)
    assert result.first == result.restored == result.unchecked == ()
    for member, wanted in OCCUR[name].items():
        assert set(log[member]) >= wanted
    result = replay(controllers[name], np.concatenate([log, log, log[: min(300, len(log))]]))
    assert (result.mismatches, result.segments) == (0, 3)  # two resets


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
def test_any_flipped_bit_is_seen_in_its_step(replayed, log, data):
    broken, row, member = flipped(log, data, 0, {"enabled"})
    result = replayed(broken)
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


def test_a_log_must_have_steps_and_its_types(replayed, log):
    with pytest.raises(ReplayError, match="no control steps"):
        replayed(log[:0])
    types = [(n, "f8" if n == "duty_percent" else log.dtype[n]) for n in log.dtype.names]
    with pytest.raises(ReplayError, match="duty_percent is float64 in the log, not float32"):
        replayed(log.astype(types))


@pytest.mark.parametrize("row", [1, 20, -2])
def test_a_missing_and_a_repeated_step_are_seen(replayed, log, row):
    assert replayed(np.delete(log, row - 1)).mismatches
    assert replayed(np.insert(log, row, log[row])).mismatches


def test_a_fault_that_outlived_a_reset_is_listed(replayed, log):
    """After the reset the fault is there, although the reading gives no reason for it."""
    clean = {
        name.replace(".", "__"): 0
        for name in log.dtype.names
        if name.startswith(("algorithm.", "guard."))
    }
    clean["guard__effort_from_c"] = -1000
    fault = {"fault__code": 6, "fault__temperature_c": 91.5, "fault__acknowledgements": 0}
    after = changed(log[:4], slice(None), **clean | fault | {"duty_percent": 0, "guard__fresh": 1})
    result = replayed(np.concatenate([log, after]))
    assert result.mismatches == 0
    assert [(found.row, found.fault_code) for found in result.restored] == [(len(log), 6)]


@pytest.mark.parametrize("times", [0, 1])
def test_the_temperature_of_an_acknowledged_fault_outlives_a_reset(replayed, log, times):
    """It was acknowledged before the reset, or between it and the first step."""
    fault = {"fault__temperature_c": 91.5, "fault__acknowledgements": times}
    after = changed(log[:4], slice(None), **fault)
    result = replayed(np.concatenate([log, after]))
    assert (result.mismatches, result.segments, result.restored) == (0, 2, ())


@pytest.mark.parametrize(
    ("on_fault", "left"),
    [("stop", {"program__state": 0, "program__ended": 3}), ("pause", {"program__state": 5})],
)
def test_an_acknowledgement_before_the_first_step_meets_the_restored_program(logs, on_fault, left):
    """Which has not been looked at yet whether it may go on; a slow loop makes it late."""
    kiln = example("kiln")
    kept = kiln.programs.model_copy(update={"on_fault": on_fault})
    restored = {"program__number": 1, "program__segment": 1, "program__segments": 4}
    restored["program__setpoint_c"] = logs["kiln"]["setpoint_c"][0]
    acknowledged = {"fault__temperature_c": 91.5, "fault__acknowledgements": 1}
    row = changed(logs["kiln"][:1], 0, **restored, **acknowledged, **left)
    assert replay(kiln.model_copy(update={"programs": kept}), row).first == ()


def test_a_mismatch_says_what_and_where(replayed, log):
    less = np.nextafter(log["duty_percent"][10], np.float32(0))
    (found,) = replayed(changed(log, 10, duty_percent=less)).first
    assert (found.row, found.time_s, found.variable) == (10, 11.0, "duty_percent")
    assert "0x" in str(found)
    assert "step 10 at 11.000 s: duty_percent is " in str(found)


def test_members_that_the_reference_lacks_are_named(replayed, log):
    wider = append_fields(log, "fault.time_s", np.zeros(len(log), "u4"), usemask=False)
    assert replayed(wider).unchecked == ("fault.time_s",)


@pytest.mark.parametrize("gain", ["kp", "ki", "kd"])
def test_gains_that_changed_show_in_what_follows(logs, gain):
    log = logs["extruder"]
    free = (log["duty_percent"] > 0) & (log["duty_percent"] < log["output_maximum_percent"])
    free &= log["mode"] == 0
    integral = log["algorithm.integral"]
    inside = integral > log["integral_minimum_percent"]
    inside &= integral < log["integral_maximum_percent"]
    row = first_row(free & inside, 3)
    twice = {f"algorithm__{gain}": 2 * log[f"algorithm.{gain}"][row]}
    found = replay(example("extruder"), changed(log, row, **twice))
    assert found.first[0].row in {row, row + 1}


def test_a_tuning_without_its_start_is_seen(logs):
    log = logs["extruder"]
    row = first_row(np.diff(log["autotune.starts"])) + 1
    starts = log["autotune.starts"][row : row + 5] - 1
    broken = changed(log[: row + 5], slice(row, None), autotune__starts=starts)
    assert replay(example("extruder"), broken).mismatches


def test_a_lost_master_does_not_explain_a_fault_of_a_loop_that_is_off(logs):
    log = logs["fabricator"]
    row = first_row((log["enabled"] == 0) & (log["steps"] > 10))
    celsius = log["temperature_c"][row]
    fault = {"fault__code": 23, "fault__temperature_c": celsius, "cooling": celsius >= 50}
    assert replay(example("fabricator"), changed(log[: row + 1], row, **fault)).mismatches


def test_another_copy_of_the_program_is_another_firing(logs):
    broken = logs["kiln"].copy()
    broken["loaded"]["segment"]["amount"][:, 0] += 60
    assert replay(example("kiln"), broken).mismatches


PROGRAM = tuple(
    f"program.{name}"
    for name in ("state", "ended", "number", "segment", "order", "argument", "leap", "kind")
)
ORDERED = ("mode", "setpoint_c", "manual_percent", "autotune.starts", "fault.code", *GAINS)
SEEN = {
    "dryer": (*ORDERED, "enabled", "autotune.result"),
    "extruder, ordered about": (*ORDERED, "fault.acknowledgements"),
    **{name: PROGRAM for name, (example, _) in RUNS.items() if example in {"kiln", "kiln_uno"}},
}
SHORT = ("dryer", "kiln, ordered about", "extruder, ordered about")
LONG = [name for name in RUNS if name not in SHORT]


def assert_models(name):
    """Every step is the model's, and so is what it takes and refuses."""
    found = run_of(name)
    result = replay(found.controller, found.log)
    assert (result.mismatches, result.segments, result.restored) == (0, 1, ())
    assert result.ticks == len(found.log)
    assert set(np.diff(found.log["steps"].astype(int))) == {1}
    assert set(found.log["fault.code"]) == ({0, 19} if name == "extruder, ordered about" else {0})
    if members := SEEN.get(name):
        example, lines = RUNS[name]
        assert course(found.log, *members) == course(modelled(example, *lines).log, *members)


@pytest.mark.parametrize("name", SHORT)
def test_every_step_is_the_models(name):
    assert_models(name)


@pytest.mark.parametrize("name", LONG)
def test_every_step_of_a_long_run_is_the_models(name):
    assert_models(name)


def test_every_step_of_a_long_standstill_is_the_models():
    """A slope that fades away ends before avr-libc's products are no longer IEEE 754's."""
    text = changed_text(
        "oven", (" 3 s\n    protection:", " 5 s\n    protection:\n      effort: off")
    )
    device = AvrDevice(example(text), whole(text))
    for until_s, reading_c in ((30, 49), (700, 50), (720, 51), (1400, 50.25)):
        device.sense("air", reading_c)
        device.advance(until_s)
    log = device.steps("air")
    assert replay(example(text), log).first == ()
    assert set(log["fault.code"]) == {0}
    assert log["algorithm.derivative"][-1] == 0


def test_the_master_is_told_what_was_refused():
    refused = run_of("dryer").device.master.refusals
    assert {int(each.time_s): each.name for each in refused} == REFUSED
    assert {each.exception for each in refused} == {3}
    assert set(run_of("dryer").log["mode"]) == {0, 1, 2}
