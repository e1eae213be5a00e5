"""What holds of a program whatever is ordered and read."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_machines import Kiln, kiln_of

from heatwright.sim.reference.copies import cell_of, column_of, copy_of
from heatwright.sim.reference.program_state import IDLE, PAUSED, RESTORING, RETURNING, RUNNING
from heatwright.sim.reference.resumed import resumed
from heatwright.sim.replay import replay

CONTROLLER = kiln_of(
    "{to: 60 °C, over: 20 s}, {hold: 6 s}, {to: 90 °C, at: as fast as possible}, "
    "{to: 20 °C, at: 6500 K/h}, {hold: until operator}",
    average="moving_average: 3",
    algorithm="ki: 0.1, feed_forward: 20",
)
LOWEST_C, HIGHEST_C = 0.0, 90.0

READINGS = st.floats(0, 90).map(lambda celsius: round(celsius * 128) / 128)
ORDERS = st.one_of(
    st.tuples(st.sampled_from(["start", "jump"]), st.integers(0, 6)),
    st.tuples(st.sampled_from(["pause", "resume", "skip", "stop"]), st.just(0)),
)
ALL_DEEDS = {"order": ORDERS, "read": READINGS, "follow": st.integers(1, 12)} | dict.fromkeys(
    ("miss", "acknowledge"), st.just(0)
)
EACH = [st.tuples(st.just(deed), what) for deed, what in ALL_DEEDS.items()]
DEEDS = st.lists(st.one_of(EACH), min_size=1, max_size=60)


def done(kiln, deed, what):
    """Do one thing; return the steps that it takes."""
    if deed in ("order", "acknowledge"):
        kiln.order(*what) if deed == "order" else kiln.operator.acknowledge()
        return []
    if deed == "follow":
        return kiln.follow(what) if kiln.record else []
    return [kiln.feed(what) if deed == "read" else kiln.miss()]


def course(deeds):
    kiln = Kiln(CONTROLLER)
    assert kiln.order("start", 1)
    records = [kiln.feed(20.0)]
    copies = [kiln.reference.program.copy]
    for deed, what in deeds:
        found = done(kiln, deed, what)
        records += found
        copies += [kiln.reference.program.copy] * len(found)
    return kiln, records, copies


@given(DEEDS)
@settings(max_examples=200)
def test_what_holds_of_every_course(deeds):
    kiln, records, copies = course(deeds)
    for record in records:
        heat_is_only_where_it_goes_on(record)
        if record["program.state"] != IDLE:
            the_setpoint_keeps_within_its_ends(record)
    for before, record in pairwise(records):
        if record["program.order"] != 3 or record["program.clock"] != 0:  # not begun anew
            clocks_stand_still_but_while_it_runs(before, record)
    points = CONTROLLER.programs.points
    dtype = [("time_s", "f8"), *kiln.reference.members, *column_of(points)]
    rows = [
        (float(number), *record.values(), cell_of(copy, points))
        for number, (record, copy) in enumerate(zip(records, copies, strict=True))
    ]
    assert replay(CONTROLLER, np.array(rows, dtype=dtype)).mismatches == 0


def heat_is_only_where_it_goes_on(record):
    state = record["program.state"]
    goes_on = state in (RUNNING, RETURNING)
    assert bool(record["enabled"]) == goes_on
    if not goes_on or record["fault.code"] or record["reading_status"]:
        assert record["duty_percent"] == 0
    assert (record["program.waiting"] == 0) or goes_on
    assert state != RESTORING


def the_setpoint_keeps_within_its_ends(record):
    now = {name: record[f"program.{name}"] for name in ("elapsed", "length", "segment_clock")}
    assert now["elapsed"] <= now["length"]
    assert now["elapsed"] <= now["segment_clock"] <= record["program.clock"]
    assert LOWEST_C <= record["program.setpoint_c"] <= HIGHEST_C
    assert record["setpoint_c"] == record["program.setpoint_c"]
    assert 1 <= record["program.segment"] <= record["program.segments"]


def clocks_stand_still_but_while_it_runs(before, record):
    moved = int(record["program.clock"]) - int(before["program.clock"])
    assert moved in ({0, 1} if before["program.state"] == RUNNING else {0})
    if record["program.state"] in (PAUSED, IDLE):
        assert record["program.energy"] == before["program.energy"]


@pytest.mark.parametrize("otherwise", ["stop", "pause"])
@pytest.mark.parametrize("state", [RESTORING, PAUSED])
@pytest.mark.parametrize("feed", ["near", "far", "none", "stopped", "resumed"])
def test_a_log_of_the_first_step_tells_what_it_found(otherwise, state, feed):
    limit = f"{{resume_within: 30 K, otherwise: {otherwise}}}"
    kiln = Kiln(kiln_of(programs=f"after_power_loss: {limit}"))
    kiln.cut(state)
    if feed in ("stopped", "resumed"):
        kiln.order("stop" if feed == "stopped" else "resume")
    found = dataclasses.replace(kiln.reference.program.now)
    record = kiln.miss() if feed == "none" else kiln.feed(35.0 if feed != "far" else 100.0)
    row = np.array([tuple(record.values())], dtype=list(kiln.reference.members))[0]
    again = Kiln(kiln.controller)
    again.reference.program.load(1, copy_of(kiln.controller.programs.stored[0]))
    again.reference.program.restore(resumed(row))
    assert again.reference.program.now.energy == found.energy
    again.operator._program = (record["program.order"], record["program.argument"])
    status = int(record["reading_status"])
    again.step(status, int(record["reading_raw"]))
    assert again.record == record
