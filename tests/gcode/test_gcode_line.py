"""Numbers, checksums, damage, floods: what arrives is done once, in order, or not at all; and
anything that a line can bring does no harm."""

import random
import re
from pathlib import Path

import pytest
from gcode_world import celsius, fault, numbered, run, spoken, tuning_ends
from rig.hosted import received, ticks
from suite import amount

WARM = "ok T:0.0 /0.0 B:0.0 /0.0 @:0"


def asked_again(problem: str, last: int) -> list[str]:
    return [f"echo:{problem}, Last Line: {last}", f"Resend: {last + 1}", "ok"]


BEGIN = numbered(0, "M110")
LONG = numbered(1, "M117 " + 200 * "x")
AGAIN = numbered(1, "M104 S50"), numbered(2, "M104 S60")
REMINDED = received(numbered(1, "M105")), ticks(20)
DAMAGED = "checksum mismatch, byte damaged"
ORDER = "Line Number is not Last Line Number+1"
WRONG = {
    **dict.fromkeys((b"N4 M105*0\n", b"N4 M105*\n", b"N4 M105*x\n", b"N4 M105 ;8*\n",
                     b"N4 M105*99999999999\n"), "checksum mismatch"),
    b"N4 M105\n": "No Checksum with line number", b"M105*37\n": "Checksum without line number",
    **{numbered(number, "M105"): ORDER for number in (6, 3, 99999999999, -1)},
    **dict.fromkeys((b"N4 M1\x0005*37\n", b"\x01\n"), DAMAGED),
}  # fmt: skip
DAMAGED_M110 = {  # the line, the number that counts from it, and the next number, which is taken
    "checksum mismatch": [
        *((line + b"*125\n", 0, 1) for line in (
            b"N7 M110 N0", b"N M110 N0", b"N0 M1x0 N0", b"N0 M10 N0", b"N0 M110 N7", b"N0 M110 0",
            b"N0 M1100N0", b"N0 M110 N0*125N1 M105*3")),
        (b"N0 M110 N0*25\n", 0, 1), (b"N-1 M1x0*15\n", -1, 0), (b"N1 M110*15\n", 1, 0),
        (b"N300 M110 N299*15\n", 299, 17)],
    "Checksum without line number": [(b"X0 M110 N0*125\n", 0, 1), (b"X-1 M110*15\n", 40, 0)],
    "No Checksum with line number": [(b"N0 M110 N0125\n", 0, 1)],
    DAMAGED: [(b"N0 M11\x000 N0*125\n", 0, 1), (b"N0 M1\x000 N0*125\n", 0, 1)],
}  # fmt: skip
NO_M110 = [line + b"*1\n" for line in (
    b"N41 M110 S60", b"N0 M104 S5", b"N41 M117 N4", b"N-2 M111", b"N1N1 M301 P34", b"N1 M117xN1",
    b"N1 M117 N1S4", b"N4 M100 M120 M010 M210 L110 M111")]  # fmt: skip


def gapped(size: int, bad: bytes = b"N5 M104 S60*7\n", before: int = 0) -> list[bytes]:
    """A wrong line, and so much of the next before the answer: the rest of it is forgotten."""
    late = numbered(6, "M104\tS60")
    said = (numbered(4, "M110"), before * b"\n", bad + late[:size], late[size:])
    return [part for each in (*said, numbered(5, "M105")) for part in (received(each), ticks(9))]


def repeated(*script: bytes) -> list[bytes]:
    """Behind line 100, after what lets a line come twice: so it does for 32 lines, no longer."""
    lines = [numbered(n, "M105") for n in range(101, 133)]
    often = *lines[:31], *lines[30:], lines[31]
    return [*spoken(numbered(100, "M110")), *script, *spoken(*often)]


OFTEN = [*31 * [WARM], "ok", WARM, *asked_again(ORDER, 132)]


ANSWERS = {
    "numbers": (spoken(numbered(-1, "M110 N-1"), *(numbered(n, "M105") for n in range(5))),
                ["ok", *5 * [WARM]]),
    "blanks and a small n": (spoken(numbered(0, "M110", " \tN"), numbered(1, "M105", "n")),
                             ["ok", WARM]),
    "renumbered": (spoken(BEGIN, numbered(1, "M110 N41"), numbered(42, "M105"), "M110 N7",
                          numbered(8, "M105")), ["ok", "ok", WARM, "ok", WARM]),
    **{f"not renumbered: {line}": (spoken(numbered(5, "M105"), line, numbered(6, "M105")),
                                   [WARM, f'echo:Unknown command: "{line[:4]}"', "ok", WARM])
       for line in ("G110 N20", "Z110 N20", "M111 N20")},
    "repeated": (repeated(*spoken(b"N101 M105*1\n", numbered(69, "M105"))),
                 ["ok", *asked_again("checksum mismatch", 100), "ok", *OFTEN]),
    "repeated after silence": (repeated(ticks(320)), ["ok", "ok", *OFTEN]),
    **{f"not repeated: {number}": (
        spoken(numbered(100, "M110"), b"N101 M105*1\n", numbered(number, "M105")),
        ["ok", *asked_again("checksum mismatch", 100), *asked_again(ORDER, 100)])
       for number in (67, 68, 102)},
    "renumbered, nothing is repeated": (
        spoken(BEGIN, b"N1 M105*1\n", "M110 N50", numbered(45, "M105")),
        ["ok", *asked_again("checksum mismatch", 0), "ok", *asked_again(ORDER, 50)]),
    **{f"renumbered by a damaged line: {line!r}": (
        spoken(numbered(40, "M110"), line, *(numbered(n, "M105") for n in (first, first - 3))),
        ["ok", *asked_again(problem, last), WARM, *asked_again(ORDER, first)])
       for problem, cases in DAMAGED_M110.items() for line, last, first in cases},
    **{f"not renumbered by a damaged line: {line!r}": (
        spoken(numbered(40, "M110"), line, numbered(1, "M105"), numbered(41, "M105")),
        ["ok", *asked_again("checksum mismatch", 40), *asked_again(ORDER, 40), WARM])
       for line in NO_M110},
    "the first number": (spoken(numbered(17, "M105"), *2 * [numbered(18, "M105")]),
                         [WARM, WARM, *asked_again(ORDER, 18)]),
    "numbers below 0": (spoken(numbered(-5, "M105"), numbered(-4, "M105")), [WARM, WARM]),
    "nothing but a number": (spoken(numbered(17, "")), ["ok"]),
    "no number of its own": (spoken(numbered(7, "M110 Nx"), numbered(8, "M105")), ["ok", WARM]),
    **{f"{number} is {taken}": (spoken(numbered(number, "M110"), b"\x01\n"),
                                ["ok", *asked_again(DAMAGED, taken)])
       for number, taken in ((9999995, 9999995), (10000007, 1000000))},
    "its letter alone": (spoken("M9999", "M"), [
        'echo:Unknown command: "M9999"', "ok", 'echo:Unknown command: "M"', "ok"]),
    **{f"wrong: {line!r}": (spoken(numbered(3, "M110"), line, numbered(4, "M105")),
                            ["ok", *asked_again(problem, 3), WARM])
       for line, problem in WRONG.items()},
    **{f"gap behind {size} bytes": (gapped(size),
                                    ["ok", *asked_again("checksum mismatch", 4), WARM])
       for size in (1, 8, 14, len(numbered(6, "M104 S60")))},
    "gap behind damage": (gapped(8, b"N5 M1\x0105*7\n"),
                          ["ok", *asked_again(DAMAGED, 4), WARM]),
    "gap where the receiver begins anew": (gapped(8, before=215),
                                           ["ok", *asked_again("checksum mismatch", 4), WARM]),
    **{f"carriage returns, {count} behind": (
        [*spoken(BEGIN), received(b"N1 M105*1\r" + count * b"M104 S60\r"), ticks(20),
         *spoken(numbered(1, "M105"))],
        ["ok", *asked_again("checksum mismatch", 0), WARM]) for count in (0, 1)},
    "asked for twice": (spoken(BEGIN, b"N1 M105*1\n", *AGAIN, *AGAIN, numbered(3, "M105")),
                        ["ok", *asked_again("checksum mismatch", 0), *4 * ["ok"],
                         WARM.replace("/0.0 B", "/60.0 B")]),
    "too long": (spoken(BEGIN, LONG, numbered(2, "M105")),
                 ["ok", "echo:Line too long, ignored", "ok", WARM]),
    "too long and damaged": (spoken(BEGIN, LONG.replace(b"xx", b"xy", 1), numbered(1, "M105")),
                             ["ok", *asked_again("checksum mismatch", 0), WARM]),
    "other letters": (spoken(BEGIN, numbered(1, "M117 größer °C"), numbered(2, "M105")),
                      ["ok", 'echo:Unknown command: "M117"', "ok", WARM]),
    "reminded": ([*REMINDED, ticks(283)], [WARM, "ok"]),
    "not yet reminded": ([*REMINDED, ticks(282)], [WARM]),
    "not yet reminded again": ([*REMINDED, ticks(582)], [WARM, "ok"]),
    "reminded again": ([*REMINDED, ticks(583)], [WARM, "ok", "ok"]),
    "reminded five times": ([*REMINDED, ticks(6000)], [WARM, *5 * ["ok"]]),
    "until it speaks again": (
        [*REMINDED, ticks(6000), received(numbered(2, "M105")), ticks(400)],
        [WARM, *5 * ["ok"], WARM, "ok"]),
    "not numbered, not reminded": ([received(b"M105\n"), ticks(2000)], [WARM]),
    "a lost line end": (  # the host gets an ok in the end, and is asked for both lines
        [received(BEGIN), ticks(20), received(AGAIN[0][:-1]), ticks(320),
         received(numbered(2, "M105")), ticks(20)],
        ["ok", "ok", *asked_again("checksum mismatch", 0)]),
    **{f"behind a checksum: {text!r}": (
        spoken(BEGIN, numbered(1, "M105 *8").replace(b"\n", text + b"\n")), ["ok", WARM])
       for text in (b" ", b" 7", b"x7", b"\t;9", b"/7", b":7")},
    **{f"unreadable: {byte}": (spoken(b"M105" + bytes([byte]) + b"\n", "M105"),
                               ["echo:Unreadable line ignored", "ok", WARM])
       for byte in (0, 1, 8, 11, 31, 127)},
    **{f"readable: {byte}": (spoken(b"M105 ;" + bytes([byte]) + b"\n"), [WARM])
       for byte in (9, 32, 126, 128, 255)},
    "the longest": (spoken("M105" + 92 * " "), [WARM]),
    "longer": (spoken("M105" + 93 * " "), ["echo:Line too long, ignored", "ok"]),
}  # fmt: skip


@pytest.mark.parametrize(("script", "answers"), ANSWERS.values(), ids=ANSWERS)
def test_what_is_answered(world: Path, script: list[bytes], answers: list[str]) -> None:
    assert run(world, *script).answers == answers


HEARD, WAITED, MINUTES = 11, 22, ticks(60_000)
"""Ticks since the first and before the last line of those that are spoken; ten minutes."""
AT_LENGTH = [*spoken("M109 S200"), MINUTES, MINUTES]
ENDED = [*AT_LENGTH, celsius(200), ticks(1000)]
SILENT = {
    "nobody, ever": ([ticks(500)], 0),
    "for hours": ([*spoken("M105"), *7 * [MINUTES]], 65_535),
    **{f"heard: {line!r}": (spoken(line), HEARD) for line in (
        "M105", "G28", "T0", "T7", "M104 S9999", "m105", " M105", numbered(7, ""), "M999")},
    **{f"not heard: {line!r}": ([*spoken("M105"), *spoken(line)], HEARD + WAITED) for line in (
        "login:", "X5", "; M105", "?", "S", "U", "F", "H", "L", "N", b"M1\x0005\n", b"N7 M105*0\n",
        b"N7 M105\n", b"M105*37\n", b"M105")},
    "a line that comes again": (spoken(BEGIN, b"N1 M105*1\n", *AGAIN[:1], *AGAIN[:1]), HEARD),
    "it waits": (AT_LENGTH, 0), "it waits no more": (ENDED, 0),
    "it has waited": ([*ENDED, ticks(100)], 100),
    "it has waited, and is told": ([*AT_LENGTH, received(b"M108\n"), ticks(1)], 0),
    "a tuning": ([*spoken("M303 S200"), MINUTES, MINUTES], 0),
}  # fmt: skip


@pytest.mark.parametrize(("script", "silent_ticks"), SILENT.values(), ids=SILENT)
def test_how_long_a_host_is_silent(world: Path, script: list[bytes], silent_ticks: int) -> None:
    """Lines that are none, and damaged ones, are no host; one that waits need not speak."""
    assert int(run(world, *script).state["silent"]) == silent_ticks


@pytest.mark.parametrize(
    "line", [b"M109\n", b"M107\n", b"M11.\n", b"M10\n", b"M1080\n", b"M108.\n", b"M410\n"]
)
def test_what_is_not_m108_does_not_end_a_wait(world: Path, line: bytes) -> None:
    script = (received(b"M109 S200\n"), ticks(50), received(line), ticks(50))
    assert "ok" not in run(world, celsius(20), *script).answers


def test_an_m999_sent_before_an_m112_does_not_undo_it(world: Path) -> None:
    """Lines that wait behind an M109 are done after the M112 that ends it; a later one counts."""
    for before in (0, 240):
        script = [celsius(20), received(before * b"\n"), ticks(20)]
        for part in (b"M109 S200\nM999\n", b"M112\n"):
            script += [received(part), ticks(30)]
        said = run(world, *script)
        assert "echo:M999 refused: M112 came after it" in said.answers
        assert (said.state["fault"], said.state["acknowledged"]) == ("19", "0")
        assert run(world, *script, received(b"M999\n"), ticks(20)).state["fault"] == "0"
    # So does one behind a line that is forgotten.
    begin = spoken(BEGIN, b"N1 M105*1\nM112\n")
    assert run(world, *begin).state["fault"] == "19"
    assert run(world, *begin, *spoken("M999")).state["fault"] == "0"


def test_each_answer_is_of_its_own_line(world: Path) -> None:
    """Also where the line to the host is full."""
    said = run(world, ticks(20), received(b"M115\nM901\nM902\n"), ticks(30)).answers
    unknown = ([f'echo:Unknown command: "M90{number}"', "ok"] for number in (1, 2))
    assert said[6:] == [*next(unknown), *next(unknown)]


def test_a_tick_takes_128_bytes(world: Path) -> None:
    """Time is kept for control; lines that are empty are no lines."""
    for count, setpoint in ((119, "60"), (120, "0")):
        script = ticks(20), received(count * b"\n" + b"M104 S60\n"), ticks(1)
        assert run(world, *script).state["setpoint"] == setpoint


def test_the_line_is_set_up(world: Path) -> None:
    """115200 baud of 16 MHz with U2X (16 + 1 eighths); both ways, with interrupts; 8N1; pull-up."""
    assert run(world, ticks(1)).state["line"] == "16 2 152 6 1"


def test_a_second_wait_is_like_the_first(world: Path) -> None:
    """Neither M108 nor the ticks at the temperature count for the next wait."""
    first = (celsius(200), received(b"M109 S200\n"), ticks(990), received(b"M108\n"), ticks(20))
    for count, ended in ((900, False), (1040, True)):
        said = run(world, *first, received(b"M109 S200\n"), ticks(count))
        assert (said.answers[-1] == "ok") is ended
    assert run(world, received(b"M108\nM109 S200\n"), ticks(50)).answers == ["ok"]


def session(seed: int) -> list[bytes]:
    chance = random.Random(seed)  # noqa: S311 - the same in every run
    script = [celsius(20)]
    for _ in range(200):
        script.append(received(something(chance)))
        if chance.random() < 0.5:
            script.append(ticks(chance.randrange(30)))
        if chance.random() < 0.05:
            script.append(celsius(chance.randrange(-100, 400)))
        if chance.random() < 0.02:
            script.append(fault(chance.randrange(1, 20)))
    return script


COMMANDS = (
    "M104 S{}", "M104 D{}", "M109 S{}", "M109 R{}", "M105", "M106 S{} P{}", "M107", "M108",
    "M110 N{}", "M112", "M115", "M155 S{}", "M301 P{} I{} D{}", "M303 S{} C{}", "M410", "M500",
    "M501", "M502", "M503", "M999", "G1 E{} F{}", "T{}", "M{}", "G{}", "M114", "M140 S{}",
)  # fmt: skip
LETTERS = b"NMGTSPIDECRF0123456789.-+*;() \t\n\r"


def something(chance: random.Random) -> bytes:
    kind = chance.random()
    if kind < 0.3:
        return chance.randbytes(chance.randrange(300))
    if kind < 0.5:
        return bytes(chance.choice(LETTERS) for _ in range(chance.randrange(140)))
    line = chance.choice(COMMANDS).format(number(chance), number(chance), number(chance))
    if kind < 0.75:
        return numbered(chance.randrange(-5, 50), line)
    return line.encode() + chance.choice((b"\n", b"\r\n", b"\r"))


def number(chance: random.Random) -> str:
    return chance.choice(
        (
            str(chance.randrange(-300, 300)), f"{chance.uniform(-1e9, 1e9):.3f}",
            chance.randrange(50) * "9", chance.randrange(50) * "0" + "7.5", "1e5", "-", "+.",
            5 * ".", "",
        )
    )  # fmt: skip


A_FAULT = re.compile(r"Error:E\d\d .*: heaters are off until M999")
"""Hosts take any error for the end of a print."""
WAKE_UP = [
    received(b"\n"), ticks(50), received(b"M108\n"), ticks(500), tuning_ends(4), ticks(500),
    received(b"\n"), ticks(50), received(b"M999\n"), ticks(50), received(b"M105\n"), ticks(50),
]  # fmt: skip


def test_whatever_comes_a_good_line_is_answered_afterwards(world: Path) -> None:
    """Nothing undefined is done (the sanitizers end the program), and no limit is passed."""
    for seed in range(amount("gcode_sessions")):
        said = run(world, *session(seed), *WAKE_UP)
        assert said.answers[-1].startswith("ok T:"), seed
        errors = [answer for answer in said.answers if answer.startswith("Error")]
        assert all(A_FAULT.fullmatch(error) for error in errors), seed
        assert 0 <= float(said.state["setpoint"]) <= 260, seed
        assert 0 <= float(said.state["fan"]) <= 100, seed
        assert all(0 <= float(gain) <= 1e6 for gain in said.state["gains"].split()), seed
