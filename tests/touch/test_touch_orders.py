"""Every order of the display does what it says, and nothing if it is malformed or out of season."""

from pathlib import Path

import pytest
from touch_kiln import (
    ANSWERS,
    FORGET,
    LOOK,
    SILENT,
    Said,
    celsius,
    damaged,
    fault,
    order,
    received,
    run,
    seconds,
    ticks,
)

START = "8 1"


def changed(said: Said, step: int) -> dict[str, str]:
    """What one order has changed: those at and before its look."""
    before, after = said.states[step - 1], said.states[step]
    return {key: value for key, value in after.items() if before[key] != value}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2 1", {"on": "1"}),
        ("21", {}),
        ("3 640.5", {"setpoint": "640.5"}),
        ("3640", {}),
        ("5 12.25", {"kp": "12.25"}),
        ("6 0.0175", {"ki": "0.0175000001"}),
        ("19 40", {"kd": "40"}),
        ("20 900", {"maximum": "900"}),
        ("20 1150", {}),
        ("15 6", {"type": "6"}),
        ("13 2", {"shown": "2", "name": "slump", "points": "1/6000/1200,"}),
        ("13 3", {"shown": "3", "name": "", "points": ""}),
        ("14 bend-it", {"name": "bend-it"}),
        ("14bend", {"name": "bend"}),
        ("11 4", {"marked": "4"}),
        ("8 2", {"state": "1", "number": "2", "segment": "1", "shown": "2",
                 "name": "slump", "points": "1/6000/1200,"}),
        ("21 3", {"page": "3"}),
        ("7 1,20.5,600:", {"points": "1/6000/1230,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"}),
    ],
)  # fmt: skip
def test_an_order_does_what_it_says(kiln: Path, text: str, expected: dict[str, str]) -> None:
    said = order(kiln, "99", text)
    assert changed(said, 1) == expected


MALFORMED = [
    "2", "2 2", "2 1 ", "2  1", "2 -1", "2 x", "2 1.0", "2 01x", "3", "3 1100.5", "3 -1",
    "3 1e2", "3 nan", "3 600C", "3 .", "3 -", "3 1.2.3", "3 99999999999", "3 4294967396",
    "4 20", "5 -1",
    "5 1000001", "6 --1", "19 ,", "20 1150.5", "20 -0.5", "15 4", "15 8", "15 256", "15 3 ",
    "8 0", "8 3", "8 4", "8 257", "8 1 2", "9 1", "9 0", "9 2", "10 1", "11 11", "11 -1",
    "13 0", "13 4", "13 260", "14", "14 ", "14    ", f"14 {100 * 'x'}", "14 thirteen char",
    '14 say "no"',
    "14 back\\slash", "18", "18 1", "21 200", "21 256", "22 1", "1 1", "23 1", "0 0", "99",
    "100", "256", "258 1", "65538 1", "", " ", "x", "-2 1", " 2 1", "2,1", "2\t1", "2 1\r",
    "2 ½", "14 \x7f", "7", "7 ",
]  # fmt: skip


def test_a_malformed_or_impossible_order_does_nothing(kiln: Path) -> None:
    said = order(kiln, "99", *MALFORMED)
    for step, text in enumerate(MALFORMED, 1):
        assert changed(said, step) == {}, text


def test_a_damaged_byte_spoils_its_order_and_no_other(kiln: Path) -> None:
    said = run(kiln, seconds(1), damaged(b"2 1;"), seconds(2), b"?", received(b"#2 1;"), seconds(2))
    assert [state["on"] for state in said.states] == ["0", "1"]


def test_a_cut_order_is_replaced_by_the_next(kiln: Path) -> None:
    said = run(kiln, seconds(1), received(b"#3 9#3 70;0;"), seconds(1))
    assert said.state["setpoint"] == "70"


def test_an_order_too_long_is_dropped(kiln: Path) -> None:
    long = b"#3 6" + 300 * b"0" + b";"
    said = run(kiln, seconds(1), received(long[:200]), seconds(1), received(long[200:]), seconds(1))
    assert said.state["setpoint"] == "20"


def test_one_order_is_done_in_a_tick(kiln: Path) -> None:
    two = received(b"#3 100;#3 200;")
    said = run(kiln, seconds(1), two, ticks(1), LOOK, ticks(1), LOOK)
    assert [state["setpoint"] for state in said.states[:2]] == ["100", "200"]


def test_a_mark_goes_with_its_program(kiln: Path) -> None:
    said = order(kiln, "11 4", "13 2")
    assert [state["marked"] for state in said.states[:2]] == ["4", "0"]


def test_an_order_that_the_ring_cuts_is_not_completed_by_the_next(kiln: Path) -> None:
    full = 251 * b"." + b"#3 123456;"
    said = run(kiln, seconds(1), received(full), seconds(1), received(b"55;"), seconds(1))
    assert said.state["setpoint"] == "20"


def test_the_switch_and_the_duty_by_hand(kiln: Path) -> None:
    said = order(kiln, "2 1", "4 35.5", "2 1", "4 101", "4 10", "2 0", "4 20")
    seen = [(state["on"], state["mode"], state["percent"]) for state in said.states[:-1]]
    assert seen == [
        ("1", "0", "0"), ("1", "1", "35.5"), ("1", "0", "35.5"), ("1", "0", "35.5"),
        ("1", "1", "10"), ("0", "0", "10"), ("0", "0", "10"),
    ]  # fmt: skip


def test_run_pause_skip_jump_stop(kiln: Path) -> None:
    said = order(kiln, START, "9 0", "9 0", "10 3", "9 1", "18", "10 9", "17", "10 2")
    seen = [(state["state"], state["segment"]) for state in said.states[:-1]]
    running, paused, returning, idle = "1", "2", "3", "0"
    # Segment 3 is returned to 540 °C first, from 20 °C: skipping waits for that.
    assert seen == [
        (running, "1"), (paused, "1"), (paused, "1"), (paused, "3"), (returning, "3"),
        (returning, "3"), (returning, "3"), (idle, "3"), (idle, "3"),
    ]  # fmt: skip
    assert said.state["ended"] == "2"
    assert said.state["on"] == "0"


def test_skip_goes_on_where_it_runs(kiln: Path) -> None:
    said = order(kiln, START, "18", "18")
    assert [state["segment"] for state in said.states[:-1]] == ["1", "2", "3"]


def test_off_stops_a_program(kiln: Path) -> None:
    said = order(kiln, START, "2 0")
    assert (said.state["state"], said.state["on"], said.state["ended"]) == ("0", "0", "2")


def test_while_a_program_runs_nothing_else_sets_the_loop(kiln: Path) -> None:
    said = order(kiln, START, "3 500", "2 1", "4 50", "8 2", "15 6")
    for step in range(1, 6):
        assert changed(said, step) == {}


def test_the_thermocouple_is_chosen_only_while_off(kiln: Path) -> None:
    said = order(kiln, "2 1", "15 6", "2 0", "15 6")
    assert [state["type"] for state in said.states[:-1]] == ["3", "3", "3", "6"]


def test_a_fault_is_acknowledged(kiln: Path) -> None:
    said = order(kiln, "16", "2 1", before=[fault(24)])
    assert [(state["fault"], state["acks"]) for state in said.states[:2]] == [("0", "1")] * 2
    assert said.state["on"] == "1"


def test_nothing_starts_while_a_fault_is_latched(kiln: Path) -> None:
    said = order(kiln, "2 1", START, "4 20", before=[fault(24)])
    assert {(state["on"], state["state"], state["mode"]) for state in said.states} == {
        ("0", "0", "0")
    }


def test_gains_are_kept_when_it_is_ordered(kiln: Path) -> None:
    said = run(
        kiln, seconds(1), received(b"#5 12;"), seconds(1), FORGET, LOOK, received(b"#5 13;"),
        seconds(1), received(b"#22;"), seconds(5), FORGET, LOOK,
    )  # fmt: skip
    assert [state["kp"] for state in said.states[:2]] == ["7.5999999", "13"]


def test_a_start_waits_for_a_reading(kiln: Path) -> None:
    said = run(
        kiln, SILENT, seconds(2), received(b"#8 1;"), seconds(2), b"?", ANSWERS, celsius(30),
        seconds(2),
    )  # fmt: skip
    assert [state["state"] for state in said.states] == ["0", "1"]
