"""Every order of the display does what it says, and nothing if it is malformed or out of season."""

from pathlib import Path

import pytest
from hosted_kiln import PAGE, Said, damaged, order, ordered, received, run, script, told

START = "8 1"
RUNNING, PAUSED, RETURNING, IDLE = "1", "2", "3", "0"


def changed(said: Said, step: int) -> dict[str, str]:
    """What one order has changed: those at and before its look."""
    before, after = said.states[step - 1], said.states[step]
    return {key: value for key, value in after.items() if before[key] != value}


DONE = {
    "2 1": {"on": "1"},
    "21": {},
    "3 640.5": {"setpoint": "640.5"},
    "3640": {},
    "5 12.25": {"kp": "12.25"},
    "5 0": {"kp": "0"},
    "5 1000000": {"kp": "1000000"},
    "6 0.0175": {"ki": "0.0175000001"},
    "19 40": {"kd": "40"},
    "20 900": {"maximum": "900"},
    "20 1150": {},
    "15 6": {"type": "6"},
    "13 2": {"shown": "2", "name": "slump", "points": "1/6000/1200,"},
    "13 3": {"shown": "3", "name": "", "points": ""},
    "14 bend-it": {"name": "bend-it"},
    "14bend": {"name": "bend"},
    "11 4": {"marked": "4"},
    "8 2": {"state": "1", "number": "2", "segment": "1", "shown": "2",
            "name": "slump", "points": "1/6000/1200,"},
    "21 3": {"page": "3"},
    f"21 {len(PAGE) - 1}": {"page": f"{len(PAGE) - 1}"},
    "7 1,20.5,600:": {"points": "1/6000/1230,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"},
}  # fmt: skip
"""What each order changes, of a kiln that does nothing."""


@pytest.mark.parametrize("text", DONE)
def test_an_order_does_what_it_says(hosted: Path, text: str) -> None:
    assert changed(order(hosted, "99", text), 1) == DONE[text]


MALFORMED = [
    "2", "2 2", "2 1 ", "2  1", "2 -1", "2 x", "2 1.0", "2 01x", "3", "3 1100.5", "3 -1",
    "3 1e2", "3 nan", "3 600C", "3 .", "3 -", "3 1.2.3", "3 99999999999", "3 4294967396",
    "4 20", "5 -1",
    "5 1000001", "6 --1", "19 ,", "20 1150.5", "20 -0.5", "15 4", "15 8", "15 256", "15 3 ",
    "8 0", "8 3", "8 4", "8 257", "8 1 2", "9 1", "9 0", "9 2", "10 1", "11 11", "11 -1",
    "13 0", "13 4", "13 260", "14", "14 ", "14    ", f"14 {100 * 'x'}", "14 thirteen char",
    '14 say "no"',
    "14 back\\slash", "18", "18 1", f"21 {len(PAGE)}", f"21 {len(PAGE) + 1}", "21 200", "21 256",
    "22 1", "1 1", "23 1", "0 0", "99", "100", "256", "258 1", "65538 1", "", " ", "x", "-2 1",
    " 2 1", "2,1", "2\t1", "2 1\r",
    "2 ½", "14 \x7f", "7", "7 ",
]  # fmt: skip


def test_a_malformed_or_impossible_order_does_nothing(hosted: Path) -> None:
    said = order(hosted, "99", *MALFORMED)
    for step, text in enumerate(MALFORMED, 1):
        assert changed(said, step) == {}, text
    assert not any(each.startswith("page ") for each in said.instructions)


TAKEN = "2 1|4 20|5 1|20 900|2 0|8 1|9 0|9 1|10 2|17|12|16|22|13 2|21 3|15 6|11 1|14 a|7 1,1,1:"
REFUSED = [*MALFORMED, "9 0", "9 1", "18", "10 1"]
"""Of a kiln that does nothing."""


def test_an_order_tells_whether_it_was_taken(hosted: Path) -> None:
    for texts, taken in ((TAKEN.split("|"), "1"), (REFUSED, "0")):
        said = run(hosted, "2 s", *(told(each) + script("3 s; look") for each in texts))
        for text, state in zip(texts, said.states, strict=False):
            assert state["taken"] == taken, text


def test_while_a_program_runs_nothing_else_sets_the_loop(hosted: Path) -> None:
    said = order(hosted, START, "3 500", "2 1", "4 50", "8 2", "15 6")
    for step in range(1, 6):
        assert changed(said, step) == {}


COURSES = {
    "the switch and the duty by hand": (
        ("2 1", "4 35.5", "2 1", "4 101", "4 10", "2 0", "4 20"),
        ("on", "mode", "percent"),
        [("1", "0", "0"), ("1", "1", "35.5"), ("1", "0", "35.5"), ("1", "0", "35.5"),
         ("1", "1", "10"), ("0", "0", "10"), ("0", "0", "10")],
    ),
    # Segment 3 is returned to 540 °C first, from 20 °C: skipping waits for that.
    "run, pause, skip, jump, stop": (
        (START, "9 0", "9 0", "10 3", "9 1", "18", "10 9", "17", "10 2"),
        ("state", "segment", "ended"),
        [(RUNNING, "1", "0"), (PAUSED, "1", "0"), (PAUSED, "1", "0"), (PAUSED, "3", "0"),
         (RETURNING, "3", "0"), (RETURNING, "3", "0"), (RETURNING, "3", "0"), (IDLE, "3", "2"),
         (IDLE, "3", "2")],
    ),
    "only 0 and 1 pause and go on": (
        (START, "9 x", "9 2", "9 0", "9 x", "9 2"), ("state",),
        [(RUNNING,), (RUNNING,), (RUNNING,), (PAUSED,), (PAUSED,), (PAUSED,)],
    ),
    "an acknowledgement leaves the loop on": (
        ("2 1", "16", "22"), ("on", "state"), [("1", "0"), ("1", "0"), ("1", "0")],
    ),
    "skip goes on where it runs": ((START, "18", "18"), ("segment",), [("1",), ("2",), ("3",)]),
    "off stops a program": (
        (START, "2 0"), ("state", "on", "ended"), [(RUNNING, "0", "0"), (IDLE, "0", "2")],
    ),
    "the thermocouple is chosen only while off": (
        ("2 1", "15 6", "2 0", "15 6"), ("type",), [("3",), ("3",), ("3",), ("6",)],
    ),
    "a mark goes with its program": (("11 4", "13 2"), ("marked",), [("4",), ("0",)]),
}  # fmt: skip
"""Orders, and what is seen of the state after each of them."""


@pytest.mark.parametrize("name", COURSES)
def test_orders_one_after_the_other(hosted: Path, name: str) -> None:
    orders, members, expected = COURSES[name]
    states = order(hosted, *orders).states[:-1]
    assert [tuple(state[member] for member in members) for state in states] == expected


LONG = b"#3 6" + 300 * b"0" + b";"
FULL = 251 * b"." + b"#3 123456;"
LINES = {
    "only its order acknowledges a fault": (
        ["2 s; fault 24; order 12; 2 s; look; order 22; 2 s; look", "order 17; 2 s; look",
         "order 2 0; 2 s"],
        "fault", 4 * ["24"],
    ),
    "a fault is acknowledged": (
        ["2 s; fault 24; order 16; 2 s; look; order 2 1; 2 s"], "fault acks on", ["0 1 0", "0 1 1"],
    ),
    "nothing starts while a fault is latched": (
        ["2 s; fault 24; order 2 1; 2 s; look; order 8 1; 2 s; look; order 4 20; 2 s"],
        "on state mode", 3 * ["0 0 0"],
    ),
    "a damaged byte spoils its order and no other": (
        ["1 s", damaged(b"2 1;"), "2 s; look; order 2 1; 2 s"], "on", ["0", "1"],
    ),
    "a cut order is replaced by the next": (
        ["1 s", received(b"#3 9#3 70;0;"), "1 s"], "setpoint", ["70"],
    ),
    "an order too long is dropped": (
        ["1 s", received(LONG[:200]), "1 s", received(LONG[200:]), "1 s"], "setpoint", ["20"],
    ),
    "one order is done in a tick": (
        ["1 s", ordered("3 100", "3 200"), "1 ticks; look; 1 ticks"], "setpoint", ["100", "200"],
    ),
    "an order that the ring cuts is not completed by the next": (
        ["1 s", received(FULL), "1 s", received(b"55;"), "1 s"], "setpoint", ["20"],
    ),
    "gains are kept when it is ordered": (
        ["1 s; order 5 12; 1 s; forget; look; order 5 13; 1 s; order 22; 5 s; forget"],
        "kp", ["7.5999999", "13"],
    ),
    "a program is not started as it was before it is kept": (
        ["1 s; order 13 1; 1 s", ordered("7 1,20,600:", "8 1"), "2 s; look; order 8 1; 2 s"],
        "state", [IDLE, RUNNING],
    ),
    "a start waits for a reading": (
        ["answers 0; 2 s; order 8 1; 2 s; look; answers 1; celsius 30; 2 s"],
        "state", [IDLE, RUNNING],
    ),
}  # fmt: skip
"""What comes over the line, and members of the state at each look."""


@pytest.mark.parametrize("name", LINES)
def test_what_comes_over_the_line(hosted: Path, name: str) -> None:
    parts, members, expected = LINES[name]
    states = run(hosted, *parts).states
    assert [" ".join(state[each] for each in members.split()) for state in states] == expected
