"""The safety relay: closed only to heat, switched without load, told from a weld by its contact."""

import pytest
from relay_firmware import (
    BOARDS,
    CONTACT_TICKS,
    OPEN,
    SETTLE_TICKS,
    WELDED,
    Broken,
    Orders,
    RelayBoard,
    course,
    problem,
)

from heatwright.sim.native.relay import Armature, Wire

STILL = Orders(wanted=False)
FIRST = 40
"""Cycles from the reset vector to the pin, some ten instructions on."""


def ticks(bench: RelayBoard, orders: Orders, count: int) -> None:
    assert problem(bench, iter([orders] * count)) == ""


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", BOARDS)
def test_every_tick_is_as_it_should_be(board: str, active: str, *, feedback: bool) -> None:
    bench = RelayBoard(board, feedback=feedback, active=active)
    assert problem(bench, course(1, 1500), seed=2 if feedback else None) == ""


def test_it_closes_before_the_heater_and_opens_with_it() -> None:
    bench = RelayBoard()
    ticks(bench, STILL, CONTACT_TICKS + 5)
    bench.tick(Orders())
    assert not bench.switches["contactor"].on  # the interrupt of this tick came before the order
    bench.tick(Orders())
    assert bench.switches["contactor"].on
    ticks(bench, Orders(), SETTLE_TICKS - 1)
    assert not bench.switches["heater"].on
    ticks(bench, Orders(), 1)
    assert bench.switches["heater"].on
    assert bench.relay.closed
    bench.tick(Orders(closed=True))
    bench.tick(Orders(closed=True))
    assert not bench.switches["contactor"].on
    assert not bench.switches["heater"].on


def test_it_opens_when_the_program_hangs() -> None:
    bench = RelayBoard()
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
    bench = RelayBoard()
    bench.fail(armature, wire)
    step = Orders(step_due=True)
    for _ in range(60):
        assert bench.tick(step) == ""
        assert bench.switches["heater"].on <= (code == OPEN)
    assert bench.get("fault.code") == code
    assert bench.get("fault.temperature_c") == 21.0
    assert not bench.switches["heater"].on
    ticks(bench, step._replace(acknowledged=True), 1)
    ticks(bench, step, 60)
    assert bench.get("fault.code") == code
    bench.fail()
    ticks(bench, STILL, 20)
    ticks(bench, step._replace(acknowledged=True), 1)
    ticks(bench, step, 60)
    assert bench.get("fault.code") == 0
    assert bench.switches["heater"].on


def test_a_weld_is_found_as_soon_as_it_has_to_open() -> None:
    bench = RelayBoard()
    ticks(bench, Orders(), 40)
    bench.fail(Armature.WELDED)
    ticks(bench, Orders(step_due=True), 200)
    assert not bench.get("fault.code")
    ticks(bench, STILL._replace(step_due=True), CONTACT_TICKS + 3)
    assert bench.get("fault.code") == WELDED


def test_bouncing_shorter_than_the_contact_s_time_is_no_fault() -> None:
    bench = RelayBoard()
    ticks(bench, Orders(step_due=True), 40)
    for _ in range(10):
        bench.fail(Armature.SOUND, Wire.SHORTED)
        ticks(bench, Orders(step_due=True), CONTACT_TICKS - 1)
        bench.fail()
        ticks(bench, Orders(step_due=True), 1)
    assert not bench.get("fault.code")
    assert bench.switches["heater"].on


@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", BOARDS)
def test_a_reset_opens_it_first_thing(board: str, active: str) -> None:
    bench = RelayBoard(board, active=active)
    ticks(bench, Orders(), 40)
    assert bench.switches["contactor"].on
    bench.avr.reset()
    bench.avr.pins.take()
    reset_at = bench.avr.cycle
    bench.avr.run(0.05)
    switch = bench.switches["contactor"]
    assert not switch.on
    assert switch.driven
    events = bench.avr.pins.take()
    mine = events[events["pin"] == switch.number]
    assert mine["cycle"][-1] - reset_at <= FIRST
    assert ((mine["state"] & 1 == 1) == (active == "low")).all()


BROKEN = [
    Broken("relay.c", "pin_relay_contact_is_high() == closed", "pin_relay_contact_is_high()"),
    Broken("relay.c", "wrong_ticks = 0;\n        return;", "return;"),
    Broken("relay.c", "        wrong_ticks++;", ""),
    Broken("relay.c", "wrong_ticks < RELAY_CONTACT_TICKS", "wrong_ticks < 9u"),
    Broken("relay.c", "closed ? FAULT_RELAY_OPEN : FAULT_RELAY_WELDED", "FAULT_RELAY_OPEN"),
    Broken("relay.c", "closed ? FAULT_RELAY_OPEN : FAULT_RELAY_WELDED", "FAULT_RELAY_WELDED"),
    Broken("relay.c", "        ticks++;", ""),
    Broken("relay.c", "    look_at_contact();", ""),
    Broken("relay.c", "closed && ticks >= RELAY_SETTLE_TICKS", "closed"),
    Broken("relay.c", "closed && ticks >= RELAY_SETTLE_TICKS", "ticks >= RELAY_SETTLE_TICKS"),
    Broken("relay.c", ">= RELAY_SETTLE_TICKS", "> RELAY_SETTLE_TICKS"),
    Broken("relay.c", "RELAY_SETTLE_TICKS && found == FAULT_NONE", "RELAY_SETTLE_TICKS"),
    Broken("relay.c", "closed || (ticks", "(ticks"),
    Broken("relay.c", "ticks >= RELAY_CONTACT_TICKS && wrong", "wrong"),
    Broken("relay.c", "RELAY_CONTACT_TICKS && wrong_ticks == 0", "RELAY_CONTACT_TICKS"),
    Broken("relay.c", "wanted && found == FAULT_NONE && may", "found == FAULT_NONE && may"),
    Broken("relay.c", "found == FAULT_NONE && may_close()", "may_close()"),
    Broken("relay.c", "found == FAULT_NONE && may_close()", "found == FAULT_NONE"),
    Broken("relay.c", "closed = next;", ""),
    Broken("relay.c", "    ticks = 0;", ""),
    Broken("relay.c", "pin_output_contactor_on();", ""),
    Broken("relay.c", "pin_output_contactor_off();", ""),
    Broken("relay.c", "found = FAULT_NONE; /*", "; /*"),
    Broken("relay.c", "fault_trip(code", "fault_trip(FAULT_RELAY_OPEN"),
    Broken("relay.c", "fault_trip(code, temperature_c);", ""),
    Broken("relay.c", "pin_relay_contact_pull_up();", ""),
    Broken("gate.c", "if (!air_wanted) {", "if (false) {"),
    Broken("gate.c", "relay_is_wanted || air_permitted", "relay_is_wanted"),
    Broken("gate.c", "relay_is_wanted || air_permitted", "true"),
    Broken("gate.c", "if (!relay_is_ready) {", "if (false) {"),
    Broken("gate.c", "relay_switch(relay_is_wanted);", ""),
    Broken("gate.c", "air_wanted = wanted;", "air_wanted = true;"),
    Broken("gate.c", "renew(&air_ticks, 0);", ""),
    Broken("reset.c", "pin_output_contactor_off();", ""),
    Broken("reset.c", "pin_output_contactor_drive();", ""),
]


def whole_problem(broken: Broken | None) -> str:
    """Say what is wrong with the relay; empty if nothing."""
    bench = RelayBoard(broken=broken)
    if not all(switch.driven for switch in bench.switches.values()):
        return "not driven"
    sound = problem(bench, course(3, 800)) or problem(bench, course(4, 1500), seed=5)
    torn = RelayBoard(broken=broken)
    torn.fail(wire=Wire.TORN)
    if found := sound or problem(torn, iter([Orders(step_due=True)] * 40)):
        return found
    return "" if torn.get("fault.code") == WELDED else "a torn wire is not seen"


def test_nothing_is_wrong_with_the_whole() -> None:
    assert whole_problem(None) == ""


@pytest.mark.parametrize(
    "broken", BROKEN, ids=lambda each: f"{each.right[:40]} -> {each.wrong[:40]}"
)
def test_what_is_broken_is_seen(broken: Broken) -> None:
    assert whole_problem(broken) != ""
