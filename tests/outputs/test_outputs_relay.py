"""The safety relay: closed only to heat, switched without load, told from a weld by its contact."""

import pytest
from relay_course import (
    CONTACT_TICKS,
    JUDGED_C,
    OPEN,
    PINS,
    SETTLE_TICKS,
    STEP,
    STILL,
    WELDED,
    Orders,
    RelayBoard,
    course,
    problem,
    relayed,
    whole_problem,
)
from rig.outputs import cause_problem, reset_problem

from heatwright.sim.native.relay import Armature, Wire


def ticks(bench: RelayBoard, orders: Orders, count: int) -> None:
    assert problem(bench, iter([orders] * count)) == ""


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", PINS)
def test_every_tick_is_as_it_should_be(board: str, active: str, *, feedback: bool) -> None:
    bench = RelayBoard(relayed(board, feedback=feedback, active=active))
    assert problem(bench, course(1, 1500), seed=2 if feedback else None) == ""


def test_it_closes_before_the_heater_and_opens_with_it() -> None:
    bench = RelayBoard(relayed())
    ticks(bench, STILL, CONTACT_TICKS + 5)
    bench.tick(Orders())
    assert not bench.outputs["contactor"].on  # the interrupt of this tick came before the order
    bench.tick(Orders())
    assert bench.outputs["contactor"].on
    ticks(bench, Orders(), SETTLE_TICKS - 1)
    assert not bench.outputs["heater"].on
    ticks(bench, Orders(), 1)
    assert bench.outputs["heater"].on
    assert bench.relay.closed
    bench.tick(Orders(closed=True))
    bench.tick(Orders(closed=True))
    assert not bench.outputs["contactor"].on
    assert not bench.outputs["heater"].on


def test_it_opens_when_the_program_hangs() -> None:
    bench = RelayBoard(relayed())
    ticks(bench, Orders(), 40)
    assert bench.relay.closed
    ticks(bench, Orders(hangs=True), 14)
    assert not bench.relay.closed


@pytest.mark.parametrize(
    ("armature", "wire", "code"),
    [
        (Armature.WELDED, Wire.SOUND, WELDED),
        (Armature.SOUND, Wire.TORN, WELDED),
        (Armature.DEAD, Wire.SOUND, OPEN),
        (Armature.SOUND, Wire.SHORTED, OPEN),
    ],
)
def test_what_is_broken_at_the_start_never_heats(armature: Armature, wire: Wire, code: int) -> None:
    bench = RelayBoard(relayed())
    bench.fail(armature, wire)
    for _ in range(60):
        assert bench.tick(STEP) == ""
        assert bench.outputs["heater"].on <= (code == OPEN)
    assert bench.get("fault.code") == code
    assert bench.get("fault.temperature_c") == JUDGED_C
    assert not bench.outputs["heater"].on
    ticks(bench, STEP._replace(acknowledged=True), 1)
    ticks(bench, STEP, 60)
    assert bench.get("fault.code") == code
    bench.fail()
    ticks(bench, STILL, 20)
    ticks(bench, STEP._replace(acknowledged=True), 1)
    ticks(bench, STEP, 60)
    assert bench.get("fault.code") == 0
    assert bench.outputs["heater"].on


def test_a_weld_is_found_as_soon_as_it_has_to_open() -> None:
    bench = RelayBoard(relayed())
    ticks(bench, Orders(), 40)
    bench.fail(Armature.WELDED)
    ticks(bench, STEP, 200)
    assert not bench.get("fault.code")
    ticks(bench, STILL._replace(step_due=True), CONTACT_TICKS + 3)
    assert bench.get("fault.code") == WELDED


def test_bouncing_shorter_than_the_contact_s_time_is_no_fault() -> None:
    bench = RelayBoard(relayed())
    ticks(bench, STEP, 40)
    for _ in range(10):
        bench.fail(Armature.SOUND, Wire.SHORTED)
        ticks(bench, STEP, CONTACT_TICKS - 1)
        bench.fail()
        ticks(bench, STEP, 1)
    assert not bench.get("fault.code")
    assert bench.outputs["heater"].on


@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", PINS)
def test_a_reset_opens_it_first_thing(board: str, active: str) -> None:
    bench = RelayBoard(relayed(board, active=active))
    ticks(bench, Orders(), 40)
    assert bench.outputs["contactor"].on
    assert reset_problem(bench, "contactor") == ""


@pytest.mark.parametrize("feedback", [True, False])
def test_nothing_is_wrong_with_the_whole(*, feedback: bool) -> None:
    assert whole_problem(relayed(feedback=feedback)) == ""


@pytest.mark.parametrize("board", PINS)
def test_what_caused_a_reset_is_told_once(board: str) -> None:
    assert cause_problem(relayed(board)) == ""
