"""A programmed loop's log replays, and nothing else does."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kilns import LOOP, PAUSED, RESTORING, RETURNING, RUNNING
from machines import events, example

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.reference import Reference
from heatwright.sim.reference.copies import copy_of
from heatwright.sim.reference.inputs import Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.program_state import ProgramState
from heatwright.sim.replay import ReplayError, replay

SAID = {
    5: "#3 30;",
    6: "#2 1;",
    12: "#2 0;",
    15: "#8 1;",
    28: "#18;",
    30: "#9 0;",
    33: "#9 1;",
    45: "#10 3;",
    60: "#5 5;#6 0.05;",
    61: "#20 25;",  # below the kiln, which is at some 27 °C by then
    69: "#20 900;",
    70: "#16;",
    73: "#8 1;",
    90: "#17;",
}
SEEN = {"state": {0, 1, 2, 3}, "ended": {0, 2, 3}, "order": {0, 1, 2, 3, 4, 5, 6}}
INPUTS = {
    "reading_raw",
    "mode",
    "manual_percent",
    "enabled",
    "loaded",
    "program.order",
    "program.argument",
    "guard.maximum_c",
}
"""What a flipped bit may leave without a difference."""
GAINS = {f"algorithm.{gain}" for gain in ("kp", "ki", "kd")}


@pytest.fixture(scope="module")
def log():
    lines = [{"at": f"{time_s} s", "send": line} for time_s, line in SAID.items()]
    kiln = example("kiln")
    return bench(kiln, ReferenceDevice(kiln), events(*lines, {"for": "100 s"})).steps[LOOP]


def test_everything_occurs(log):
    for name, wanted in SEEN.items():
        assert set(log[f"program.{name}"]) == wanted
    assert set(log["fault.code"]) == {0, 6}
    assert set(log["guard.maximum_c"]) == {1150.0, 25.0, 900.0}


def test_its_own_steps_are_equal(log):
    result = replay(example("kiln"), log)
    assert (result.ticks, result.mismatches, result.segments) == (len(log), 0, 1)
    assert result.first == result.restored == result.unchecked == ()


@given(data=st.data())
@settings(deadline=None, max_examples=100)
def test_any_flipped_bit_of_what_follows_is_seen(log, data):
    row = data.draw(st.integers(1, len(log) - 1))
    names = {*log.dtype.names} - {"time_s", "setpoint_c", "reading_status", *INPUTS, *GAINS}
    member = data.draw(st.sampled_from(sorted(names)))
    broken = log[: row + 20].copy()
    cell = broken[member][row : row + 1].view(np.uint8)
    bit = data.draw(st.integers(0, 8 * len(cell) - 1))
    cell[bit // 8] ^= 1 << bit % 8
    assert replay(example("kiln"), broken).mismatches


@pytest.mark.parametrize("member", ["loaded", "program.leap", "guard.maximum_c", "reading_c"])
def test_a_log_must_have_them(log, member):
    names = [name for name in log.dtype.names if name != member]
    with pytest.raises(ReplayError, match=f"lacks {member}"):
        replay(example("kiln"), log[names])


def test_another_copy_of_the_program_is_another_firing(log):
    broken = log.copy()
    broken["loaded"]["segment"]["amount"][:, 0] += 60
    assert replay(example("kiln"), broken).mismatches


def after_a_reset(log, state, feed_c, *, code=0, relay=False):
    """The steps of a model that lost its power in the last step of a log."""
    kiln = example("kiln")
    reference = Reference(kiln, LOOP)
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
        orders = Orders(
            gains=gains,
            enabled=0,
            maximum_c=Single(1150),
            relay_fault=code if relay else 0,
        )
        status = 1 if number < 1 and feed_c is None else 0
        raw = 0 if status else round((feed_c or 27.0) * 128)
        rows.append(
            (float(number), *reference.step(status, raw, Single(20), orders=orders).values())
        )
    kept = np.empty(len(rows), log.dtype)
    plain = np.array(rows, [("time_s", "f8"), *reference.members])
    for name in plain.dtype.names:
        kept[name] = plain[name]
    kept["loaded"] = log["loaded"][-1]
    return kept


@pytest.mark.parametrize("state", [RESTORING, PAUSED])
@pytest.mark.parametrize("feed_c", [27.0, 100.0, None])
def test_a_program_that_outlived_a_reset_is_followed(log, state, feed_c):
    after = after_a_reset(log, state, feed_c)
    result = replay(example("kiln"), np.concatenate([log, after]))
    assert (result.mismatches, result.segments, result.restored) == (0, 2, ())
    if state == RESTORING and feed_c != 100.0:
        assert RETURNING in after["program.state"]


@pytest.mark.parametrize("code", [6, 25])
def test_with_a_fault_that_outlived_it_too(log, code):
    after = after_a_reset(log, RESTORING, 27.0, code=code)
    result = replay(example("kiln"), np.concatenate([log, after]))
    assert (result.mismatches, [each.fault_code for each in result.restored]) == (0, [code])


def test_a_relay_that_fails_in_the_first_step_is_no_such_fault(log):
    after = after_a_reset(log, RESTORING, 27.0, code=25, relay=True)
    result = replay(example("kiln"), np.concatenate([log, after]))
    assert (result.mismatches, result.restored) == (0, ())
