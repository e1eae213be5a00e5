"""Programs after a loss of power: what the first steps make of a record."""

import dataclasses

import numpy as np
import pytest
from programmed_kiln import Kiln, controller_of

from heatwright.sim.reference.copies import copy_of
from heatwright.sim.reference.program_state import (
    FAILED,
    IDLE,
    PAUSED,
    POWER_COLD,
    RESTORING,
    RETURNING,
    RUNNING,
    STOPPED,
)
from heatwright.sim.reference.resumed import resumed

STOPS = "after_power_loss: {resume_within: 30 K, otherwise: stop}"
PAUSES = "after_power_loss: {resume_within: 30 K, otherwise: pause}"
NEVER = "after_power_loss: stop"


def cut(programs=STOPS, state=RESTORING, before_c=35.0):
    """A kiln that lost its power in its first ramp, at 35 °C."""
    lost = Kiln(controller_of(programs=programs))
    lost.start()
    lost.follow(15)
    kiln = Kiln(lost.controller)
    run = kiln.reference.program
    run.load(1, copy_of(kiln.controller.programs.stored[0]))
    run.restore(
        dataclasses.replace(
            lost.reference.program.now, state=state, before_c=np.float32(before_c), leap=0
        )
    )
    return kiln


@pytest.mark.parametrize("found_c", [5.0, 35.0, 65.0])
def test_within_the_limit_it_returns_and_goes_on(found_c):
    kiln = cut()
    kiln.miss()
    assert (kiln.of_program("state"), kiln.record["enabled"]) == ((RESTORING,), 0)
    record = kiln.feed(found_c)
    assert kiln.of_program("state", "leap", "elapsed") == (RETURNING, 1, 15)
    assert (record["enabled"], record["setpoint_c"]) == (1, 35.0)
    kiln.feed(34.5)
    assert kiln.feed(34.5)["setpoint_c"] == 36.0
    assert kiln.of_program("state", "segment", "clock") == (RUNNING, 1, 16)


@pytest.mark.parametrize("found_c", [4.9921875, 65.0078125])
@pytest.mark.parametrize(("programs", "state"), [(STOPS, IDLE), (PAUSES, PAUSED)])
def test_beyond_it_it_does_what_the_spec_says(programs, state, found_c):
    kiln = cut(programs)
    record = kiln.feed(found_c)
    assert (kiln.of_program("state"), record["enabled"]) == ((state,), 0)
    assert kiln.of_program("ended") == (POWER_COLD if state == IDLE else 0,)


def test_resume_within_nothing_is_never():
    kiln = cut(NEVER)
    kiln.feed(35.0)
    assert kiln.of_program("state", "ended") == (IDLE, POWER_COLD)


def test_it_can_be_stopped_before_there_is_a_reading():
    kiln = cut()
    assert not kiln.order("jump", 1)
    assert not kiln.order("pause")
    assert kiln.order("stop")
    kiln.miss()
    assert kiln.of_program("state", "ended") == (IDLE, STOPPED)


def test_a_fault_that_outlived_the_reset_ends_it():
    kiln = cut()
    kiln.reference.restore(6, np.float32(1100))
    kiln.feed(35.0)
    assert kiln.of_program("state", "ended") == (IDLE, FAILED)


def test_what_was_paused_stays_paused():
    kiln = cut(state=PAUSED)
    kiln.feed_all([35.0] * 3)
    assert (kiln.of_program("state"), kiln.record["enabled"]) == ((PAUSED,), 0)


@pytest.mark.parametrize("programs", [STOPS, PAUSES])
@pytest.mark.parametrize("state", [RESTORING, PAUSED])
@pytest.mark.parametrize("feed", ["near", "far", "none", "stopped", "resumed"])
def test_a_log_of_the_first_step_tells_what_it_found(programs, state, feed):
    kiln = cut(programs, state)
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
    again._step(status, int(record["reading_raw"]))
    assert again.record == record
