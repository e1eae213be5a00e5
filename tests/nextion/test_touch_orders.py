"""Every order of the display does what it says, and nothing if it is malformed or out of season."""

import random
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from display_model import Grammar, Malice, frames, noise, segments_of
from hosted_kiln import TOUCHED, Said, damaged, flooded, order, ordered, received, run, script, told

from heatwright.sim.reference.interfaces.nextion import Editor

GIVEN = "1/5400/3600,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"
"""The first program: kind, tenths of a degree, seconds or tenths of a kelvin per hour."""
IDLE, RUNNING = "0", "1"
MEASURED = {"waiting", "works", "saves", "temperature", "target", "duty", "clock", "passed",
            "energy"}  # fmt: skip
"""What an order changes later, or time does."""


def changed(said: Said, step: int) -> dict[str, str]:
    before, after = said.states[step - 1], said.states[step]
    return {
        key: value for key, value in after.items() if before[key] != value and key not in MEASURED
    }


DONE = {
    "2 1": {"on": "1"}, "21": {}, "3 640.5": {"setpoint": "640.5"}, "3640": {},
    "5 999.999995": {"kp": "1000"}, "5 0": {"kp": "0"}, "5 1000000": {"kp": "1000000"},
    "6 0.0175": {"ki": "0.0175000001"}, "19 40": {"kd": "40"},
    "20 900": {"maximum": "900"}, "20 1150": {}, "15 6": {"type": "6"},
    "13 2": {"shown": "2", "name": "slump", "points": "1/6000/1200,"},
    "13 3": {"shown": "3", "name": "", "points": ""},
    "14 bend-it": {"name": "bend-it"}, "14 ~ ~": {"name": "~ ~"}, "14bend": {"name": "bend"},
    "14 abcdefghijkl": {"name": "abcdefghijkl"}, "14 a ": {"name": "a "}, "11 10": {"marked": "10"},
    "14 abcdefghijklm": {},
    "8 2": {"state": "1", "number": "2", "segment": "1", "shown": "2",
            "name": "slump", "points": "1/6000/1200,"},
    "21 3": {"page": "3"}, "21 23": {"page": "23"},
    "7 1,20.5,600:": {"points": "1/6000/1230,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"},
}  # fmt: skip
"""What each order changes, of a kiln that does nothing."""


@pytest.mark.parametrize("text", DONE)
def test_an_order_does_what_it_says(hosted: Path, text: str) -> None:
    assert changed(order(hosted, "99", text), 1) == DONE[text]


TAKEN = "2 1|4 20|5 1|20 900|2 0|8 1|9 0|9 1|10 2|17|12|16|22|13 2|21 3|15 6|11 1|14 a|7 1,1,1:"
REFUSED = "9 0|9 1|9 2|10 1|18|8 3|8 0|13 0|13 99|7 0,1,1:|7 1,-5,100,3:|7 1,-5,100,4:"
"""Orders that a kiln refuses which does nothing; place 3 is empty."""


def test_an_order_tells_whether_it_was_taken(hosted: Path) -> None:
    for texts, taken in ((TAKEN, "1"), (REFUSED, "0")):
        orders = texts.split("|")
        said = run(hosted, "2 s", *(told(each) + script("3 s; look") for each in orders))
        for text, state in zip(orders, said.states, strict=False):
            assert state["taken"] == taken, text


COURSES = {
    "the switch and the duty by hand": (
        "2 1|4 35.5|2 1|4 101|4 10|2 0|4 20", "on mode percent",
        "1 0 0|1 1 35.5|1 0 35.5|1 0 35.5|1 1 10|0 0 10|0 0 10"),
    # Segment 4 holds 800 °C, to which it is returned first: skipping waits for that.
    "run, pause, skip, jump, stop": (
        "8 1|9 0|9 0|10 3|9 1|18|10 9|17|10 2", "state segment ended",
        "1 1 0|2 1 0|2 1 0|2 4 0|3 4 0|3 4 0|3 4 0|0 4 2|0 4 2"),
    "go here goes to a row's temperature and on with the next one": (
        "8 1|10 1|10 2|10 3|10 0|10 5|10 6", "state segment target",
        "1 1 20.1444435|3 2 540|3 3 540|3 4 800|1 1 20|3 5 510|3 5 510"),
    "only 0 and 1 pause and go on": ("8 1|9 x|9 2|9 0|9 x|9 2", "state", "1|1|1|2|2|2"),
    "an acknowledgement leaves the loop on": ("2 1|16|22", "on state", "1 0|1 0|1 0"),
    "skip goes on where it runs": ("8 1|18|18", "segment", "1|2|3"),
    "while a program runs nothing else sets the loop": (
        "8 1|3 500|2 1|4 50|8 2|15 6", "setpoint mode number type", "|".join(6 * ["20 0 1 3"])),
    "off stops a program": ("8 1|2 0", "state on ended", "1 0 0|0 0 2"),
    "the thermocouple is chosen only while off": ("2 1|15 6|2 0|15 6", "type", "3|3|3|6"),
    "a mark goes with its program": ("11 4|13 2", "marked", "4|0"),
    "a change outlives a look at another program": (
        "13 3|7 1,20,600:|14 new|13 1|13 3", "name points",
        f" | 1/6000/1200,|new 1/6000/1200,|fuse {GIVEN}|new 1/6000/1200,"),
    "a name without segments does not": (
        "13 3|14 new|13 1|13 3", "name points", f" |new |fuse {GIVEN}| "),
    "the program that runs is not changed": (
        "8 1|7 1,0,0:|18|18|18", "points state segment",
        f"{GIVEN} 1 1| 1 1| 1 2| 1 3| 1 4"),
}  # fmt: skip
"""Orders, and what is seen of the state after each (0 idle, 1 runs, 2 paused, 3 returns)."""


@pytest.mark.parametrize("name", COURSES)
def test_orders_one_after_the_other(hosted: Path, name: str) -> None:
    orders, members, expected = COURSES[name]
    states = order(hosted, *orders.split("|")).states[:-1]
    assert [" ".join(state[each] for each in members.split()) for state in states] == (
        expected.split("|")
    )


LONG = b"#3 6" + 300 * b"0" + b";"
FULL = 251 * b"." + b"#3 123456;"
LINES = {
    "the longest order is taken, and none longer": (
        ["1 s", flooded(b"#3 " + 257 * b"0" + b"640;"), "1 s; look",
         flooded(b"#3 " + 258 * b"0" + b"70;"), "1 s; look",
         flooded(b"#3 " + 259 * b"0" + b"60;"), "1 s"],
        "setpoint", ["640", "70", "70"]),
    "only its order acknowledges a fault": (
        ["2 s; fault 24; order 12; 2 s; look; order 22; 2 s; look", "order 17; 2 s; look",
         "order 2 0; 2 s"],
        "fault", 4 * ["24"]),
    "a fault is acknowledged": (
        ["2 s; fault 24; order 16; 2 s; look; order 2 1; 2 s"], "fault acks on", ["0 1 0", "0 1 1"],
    ),
    "a fault that is locked out waits for a person": (
        ["2 s; trips 2; fault 24; order 16; 2 s; look; trips 2; order 16; 2 s"],
        "fault acks", ["24 0", "0 1"]),
    "nothing starts while a fault is latched": (
        ["2 s; fault 24; order 2 1; 2 s; look; order 8 1; 2 s; look; order 4 20; 2 s"],
        "on state mode", 3 * ["0 0 0"]),
    "a damaged byte spoils its order and no other": (
        ["1 s", damaged(b"2 1;"), "2 s; look", damaged(b"2 1;", "b"), "2 s; look; order 2 1; 2 s"],
        "on", ["0", "0", "1"]),
    "a byte that is no character spoils its order": (
        ["1 s", received(b"#14 a\x7fb;"), "1 s; look", received(b"#14 a\x1fb;"), "1 s"],
        "name", ["fuse", "fuse"]),
    "damaged bytes are no answer": (
        ["1 s; page points; 1 s", damaged(b"\0\0\xff\xff\xff"), "1 s"], "page", ["3"]),
    "an answer ends what is done in a tick": (
        ["1 s; display 0", received(b"\x24\xff\xff\xff#3 100;"), "1 ticks; look; 1 ticks; look",
         received(b"\x66\3\xff\xff\xff#3 110;"), "1 ticks; look; 1 ticks; look",
         received(b"\0\0\0\xff\xff\xff#3 120;"), "1 ticks; look; 1 ticks"],
        "setpoint", ["20", "100", "100", "110", "110", "120"]),
    "a cut order is replaced by the next": (
        ["1 s", received(b"#3 9#3 70;0;"), "1 s"], "setpoint", ["70"]),
    "an order too long is dropped": (
        ["1 s", received(LONG[:200]), "1 s", received(LONG[200:]), "1 s"], "setpoint", ["20"]),
    "one order is done in a tick": (
        ["1 s", ordered("3 100", "3 200"), "1 ticks; look; 1 ticks"], "setpoint", ["100", "200"]),
    "an order that the ring cuts is not completed by the next": (
        ["1 s", received(FULL), "1 s", received(b"55;"), "1 s"], "setpoint", ["20"]),
    "the ring takes 254 bytes": (
        ["1 s", received(247 * b"." + b"#3 640;"), "1 s; look",
         received(248 * b"." + b"#3 100;"), "1 s"],
        "setpoint", ["640", "640"]),
    "gains are kept when it is ordered": (
        ["1 s; order 5 12; 1 s; forget; look; order 5 13; 1 s; order 22; 5 s; forget"],
        "kp", ["7.5999999", "13"]),
    "a program is not started as it was before it is kept": (
        ["1 s; order 13 1; 1 s", ordered("7 1,20,600:", "8 1"), "2 s; look; order 8 1; 2 s"],
        "state", [IDLE, RUNNING]),
    "a start waits for a reading": (
        ["answers 0; 2 s; order 8 1; 2 s; look; answers 1; celsius 30; 2 s"],
        "state", [IDLE, RUNNING]),
}  # fmt: skip
"""What comes over the line, and members of the state at each look."""


@pytest.mark.parametrize("name", LINES)
def test_what_comes_over_the_line(hosted: Path, name: str) -> None:
    parts, members, expected = LINES[name]
    states = run(hosted, *parts).states
    assert [" ".join(state[each] for each in members.split()) for state in states] == expected


# -- order 7: segments put in, changed, taken away; all that was sent, or nothing

AMOUNTS = ("0", "0.004", "0.005", "0.01", "0.02", "1", "2.016", "20", "60.5", "6553.54",
           "6553.55", "44640", "44640.004", "44640.01", "999999.99", "999999.994", "999999.995",
           "7158279", "42949673.6", "9999999.999", "10000000", "-1", "-0.01", "-0.004", "", ".",
           "1h30", "1h", "-99999h", "-9999999h1", "20.0049", "20.00509", "0h59.99", "0h59.994",
           "0h59.995", "0h60", "743h59.98", "744h", "744h0.01", "1h-1", "-1h00", "-0h1", "h30",
           "h", "1hh", "0h61", "16666h", "16667h", "715828h", "1.5h", "1.004h", "1h2h", "1h.",
           "99999999h")  # fmt: skip
TARGETS = ("0", "-0", "-0.04", "-0.05", "0.04", "0.05", "20", "540", "540.04", "540.05",
           "540.049", "540.0509", "1100", "1100.04", "1100.05", "3276.7", "3276.8", "-3276.7",
           "-3276.8", "99999999.9", "100000000", "")  # fmt: skip
KIND = ("", "", "", ",0", ",1", ",1", ",2", ",3", ",4", ",5", ",")


def change(chance: random.Random) -> str:
    text = ""
    for _ in range(chance.choice((1, 1, 1, 1, 1, 1, 2, 3))):
        amount = chance.choice((*AMOUNTS, *20 * ("20",), f"{chance.uniform(0, 100):.4f}"))
        target = chance.choice((*TARGETS, *9 * ("540", "600"), f"{chance.uniform(0, 1100):.2f}"))
        text += f"{chance.randint(0, 12)},{amount},{target}{chance.choice(KIND)}:"
    at = chance.randrange(len(text))
    return text if chance.random() < 0.8 else text[:at] + chance.choice(",:1x") + text[at + 1 :]


def test_whatever_is_sent_as_segments_makes_what_is_documented(hosted: Path) -> None:
    chance = random.Random(8)  # noqa: S311 - no secret
    texts = [change(chance) for _ in range(3000)]
    said = run(hosted, "2 s; look", *(told(f"7 {text}") + script("look") for text in texts))
    editor = Editor(TOUCHED)
    for text, before, after in zip(texts, said.states, said.states[1:], strict=False):
        expected, taken = segments_of(before), "0"
        with suppress(ValueError):
            expected, taken = editor.edited(expected, text), "1"
        assert (segments_of(after), after["taken"]) == (expected, taken), (before, text)


# -- whatever comes, nothing is read or written where it must not be: sanitizers watch all

BYTES = 1_000_000
ORDERS = 10_000
PER_RUN = 500
LONGEST = 200  # length of an order's text, in bytes


@cache  # they take longer to make than to play: an arena's trials share them
def malformed() -> list[tuple[list[bytes], list[str]]]:
    """Return what each run sends, and the orders in it without what is around them."""
    malice = Malice(Grammar(TOUCHED), seed=5)
    runs = [list(malice.orders(PER_RUN)) for _ in range(ORDERS // PER_RUN)]
    return [
        (bad, [text for data in bad for text in frames(data) if len(text) < LONGEST])
        for bad in runs
    ]


@pytest.mark.parametrize("seed", range(4))
def test_a_million_random_bytes(hosted: Path, seed: int) -> None:
    """In four runs: idle, heating, with a program, with a fault. It still listens after them."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    begins = ("2 s", "2 s; order 2 1; 2 s", "2 s; order 8 1; 2 s", "2 s; fault 6; 2 s")[seed]
    noisy = flooded(noise(chance, BYTES // 4))
    assert run(hosted, begins, noisy, "2 s; page points; 1 s").state["page"] == "3"


def test_ten_thousand_malformed_orders(hosted: Path) -> None:
    """None of them is taken, or changes anything that an order can change."""
    for bad, alone in malformed():
        # The `;` ends what one has left open: the next must not make an order of it.
        sent = [flooded(data + b"\n;") + script("3 ticks; look") for data in bad]
        said = run(hosted, "2 s; look", *sent, "1 s")
        first = said.states[0]
        for data, state in zip(bad, said.states[1:], strict=False):
            assert state == first, data
        assert not any(each.startswith("page ") for each in said.instructions)
        said = run(hosted, "2 s; look", *(told(text) + script("look") for text in alone))
        assert said.states[1:] == len(said.states[1:]) * [first]


def test_a_flood_of_sound_orders_is_taken_one_by_one(hosted: Path) -> None:
    """One in a tick; what the ring has no room for is lost whole."""
    flood = ordered(*(f"3 {number}" for number in range(100, 1100)))
    said = run(hosted, "2 s", flood, "5 s")
    assert 100 <= float(said.state["setpoint"]) < 160
