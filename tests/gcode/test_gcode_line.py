"""Numbers, checksums, damage, floods: what arrives is done once, in order, or not at all."""

from pathlib import Path

import pytest
from gcode_world import celsius, flagged, numbered, received, run, talk, ticks

WARM = "ok T:0.0 /0.0 B:0.0 /0.0 @:0"


def asked_again(problem: str, last: int) -> list[str]:
    return [f"Error:{problem}, Last Line: {last}", f"Resend: {last + 1}", "ok"]


def test_numbered_lines(world: Path) -> None:
    said = talk(world, numbered(-1, "M110 N-1"), *(numbered(n, "M105") for n in range(5)))
    assert said.answers == ["ok"] + 5 * [WARM]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (b"N4 M105*0\n", "checksum mismatch"),
        (b"N4 M105*\n", "checksum mismatch"),
        (b"N4 M105*x\n", "checksum mismatch"),
        (b"N4 M105*99999999999\n", "checksum mismatch"),
        (b"N4 M105\n", "No Checksum with line number"),
        (b"M105*37\n", "No Line Number with checksum"),
        (numbered(6, "M105"), "Line Number is not Last Line Number+1"),
        (numbered(3, "M105"), "Line Number is not Last Line Number+1"),
        (numbered(99999999999, "M105"), "Line Number is not Last Line Number+1"),
        (numbered(-5, "M105"), "Line Number is not Last Line Number+1"),
        (b"N4 M1\x0005*37\n", "Line damaged"),
        (b"\x01\n", "Line damaged"),
    ],
)
def test_what_is_wrong_is_asked_for_again(world: Path, line: bytes, problem: str) -> None:
    said = talk(world, numbered(3, "M110"), line, numbered(4, "M104 S50"))
    assert said.answers == ["ok", *asked_again(problem, 3), "ok"]
    assert said.state["setpoint"] == "50"


@pytest.mark.parametrize("half", [1, 8, 14, 15])
def test_what_follows_a_gap_is_forgotten(world: Path, half: int) -> None:
    """To the end of the line that is coming in, if there is one."""
    bad, late = numbered(5, "M104 S50"), numbered(6, "M104 S60")
    assert len(late) == 15
    said = run(
        world, received(numbered(4, "M110")), ticks(9),
        received(bad.replace(b"5", b"6", 1) + late[:half]), ticks(9), received(late[half:]),
        ticks(9), received(numbered(5, "M105")), ticks(9),
    )  # fmt: skip
    assert said.answers == ["ok", *asked_again("checksum mismatch", 4), WARM]


def test_a_line_that_was_asked_for_twice_is_done_once(world: Path) -> None:
    lines = [numbered(1, "M104 S50"), numbered(2, "M104 S60")]
    said = talk(
        world, numbered(0, "M110"), b"N1 M105*1\n", *lines, *lines, numbered(3, "M105")
    )  # fmt: skip
    assert said.answers[4:] == ["ok", "ok", "ok", "ok", WARM.replace("/0.0 B", "/60.0 B")]
    assert said.state["setpoint"] == "60"


def test_a_number_is_taken_as_it_is_when_it_is_the_first(world: Path) -> None:
    assert talk(world, numbered(17, "M105"), numbered(18, "M105")).answers == [WARM, WARM]


def test_a_long_line_that_is_intact_does_not_stop_a_print(world: Path) -> None:
    long = numbered(1, "M117 " + 200 * "x")
    said = talk(world, numbered(0, "M110"), long, numbered(2, "M105"))
    assert said.answers == ["ok", "echo:Line too long, ignored", "ok", WARM]
    damaged = long.replace(b"xx", b"xy", 1)
    said = talk(world, numbered(0, "M110"), damaged, numbered(1, "M105"))
    assert said.answers == ["ok", *asked_again("checksum mismatch", 0), WARM]


def test_text_in_other_letters_is_no_damage(world: Path) -> None:
    said = talk(world, numbered(0, "M110"), numbered(1, "M117 größer °C"), numbered(2, "M105"))
    assert said.answers == ["ok", 'echo:Unknown command: "M117"', "ok", WARM]


def test_a_host_that_missed_an_ok_gets_another(world: Path) -> None:
    """Five, three seconds apart, and no more until it speaks again."""
    begin = [received(numbered(1, "M105")), ticks(20)]
    assert run(world, *begin, ticks(295)).answers == [WARM, "ok"]
    assert run(world, *begin, ticks(270)).answers == [WARM]
    assert run(world, *begin, ticks(6000)).answers == [WARM] + 5 * ["ok"]
    again = (received(numbered(2, "M105")), ticks(400))
    assert run(world, *begin, ticks(6000), *again).answers == [WARM] + 5 * ["ok"] + [WARM, "ok"]


def test_who_does_not_number_is_not_reminded(world: Path) -> None:
    assert run(world, received(b"M105\n"), ticks(2000)).answers == [WARM]


def test_a_lost_line_end_does_not_stop_a_print(world: Path) -> None:
    """The host gets an ok in the end, sends the next line, and is asked for both."""
    joined = [received(numbered(1, "M104 S50")[:-1]), ticks(320), received(numbered(2, "M105"))]
    said = run(world, received(numbered(0, "M110")), ticks(20), *joined, ticks(20))
    assert said.answers == ["ok", "ok", *asked_again("checksum mismatch", 0)]


@pytest.mark.parametrize(
    "line",
    [
        b"M112\n", b"m112\r", b"N5 M112*33\n", b"N-7M112\n", b"  M112 ;now\n", b"M112(now)\n",
        b"M0112\n", b"M112 S1\n", b"N0M112\n", b"N9M112\n", b"N10 \tM112*1\n", b"\tM112\t\n",
        b"M112;\n", b"M9 M1\nM112\n", b"n5 m112\n", b"M105\rM112\r",
    ],
)  # fmt: skip
@pytest.mark.parametrize("before", [b"", b"M109 S200\n", b"M109 S200\n" + 500 * b"M105\n"])
def test_m112_stops_at_once(world: Path, line: bytes, before: bytes) -> None:
    """Whatever is waited for, however much waits before it."""
    said = run(world, celsius(20), received(before), ticks(20), received(line), ticks(1))
    assert said.state["fault"] == "19"


@pytest.mark.parametrize(
    "line",
    [
        b"M1120\n", b"M11\n", b"M12\n", b"XM112\n", b"; M112\n", b"M117 M112\n", b"M112.5\n",
        b"N5 N6 M112\n", b"GM112\n", b"M1 12\n", b"N5;M112\n", b"M65648\n", b"M112",
        b"M104 S112\n", b"N112\n", b"-M112\n", b"M\x80112\n", b"M-112\n", b"X112\n", b"N5X112\n",
        b"N5 X112\n", b"N/M112\n", b"N:M112\n", b"N5,M112\n", b"N5 5M112\n", b"M10<\n", b"M9F\n",
        b"M13\x1e\n", b"M:2\n", b"M1M112\n", b"MM112\n",
    ],
)  # fmt: skip
def test_what_only_looks_like_m112_does_not(world: Path, line: bytes) -> None:
    said = run(world, received(line), ticks(1))
    assert said.state["fault"] == "0"


def test_m112_in_a_flood_that_overflows(world: Path) -> None:
    said = run(world, received(5000 * b"M105 " + b"\nM112\n"), ticks(1))
    assert said.state["fault"] == "19"


def test_what_did_not_fit_is_not_done_by_halves(world: Path) -> None:
    """The lines of a flood are done whole, or not: no S2 from the beginning of S200."""
    for length in range(200, 270):
        flood = b";" * (length - 1) + b"\n" + 3 * b"M104 S200\n"
        said = run(world, received(flood), ticks(40), received(b"\nM105\n"), ticks(20))
        assert said.state["setpoint"] in {"0", "200"}
        assert said.answers[-1].startswith("ok T:")


@pytest.mark.parametrize(
    "others", [b"M112\nM108\n", b"M108\nM112\n", b"M112\nM410\n", b"M410\nM112\n"]
)
def test_urgent_commands_do_not_displace_each_other(world: Path, others: bytes) -> None:
    begin = (celsius(20), received(b"M109 S200\n"), ticks(20), received(300 * b";"))
    said = run(world, *begin, received(b"\n" + others), ticks(1))
    assert said.state["fault"] == "19"


@pytest.mark.parametrize(
    "line", [b"M109\n", b"M107\n", b"M11.\n", b"M10\n", b"M1080\n", b"M108.\n", b"M410\n"]
)
def test_what_is_not_m108_does_not_end_a_wait(world: Path, line: bytes) -> None:
    script = (received(b"M109 S200\n"), ticks(50), received(line), ticks(50))
    assert "ok" not in run(world, celsius(20), *script).answers


def test_an_m999_sent_before_an_m112_does_not_undo_it(world: Path) -> None:
    """Lines that wait behind an M109 are done after the M112 that ends it; a later one counts."""
    begin = (celsius(20), received(b"M109 S200\nM999\n"), ticks(20), received(b"M112\n"), ticks(30))
    said = run(world, *begin)
    assert "Error:M999 refused: M112 came after it" in said.answers
    assert (said.state["fault"], said.state["acknowledged"]) == ("19", "0")
    assert run(world, *begin, received(b"M999\n"), ticks(20)).state["fault"] == "0"


@pytest.mark.parametrize("flag", [1 << 4, 1 << 3], ids=["framing", "overrun"])
def test_a_damaged_byte_is_never_taken_for_another(world: Path, flag: int) -> None:
    for at in range(4):
        damaged = flagged(flag, b"M112"[at])
        script = (received(b"M112"[:at]), damaged, received(b"M112"[at + 1 :] + b"\n"), ticks(20))
        said = run(world, *script)
        assert said.state["fault"] == "0"
        assert said.answers == ["echo:Unreadable line ignored", "ok"]


def test_the_line_is_set_up(world: Path) -> None:
    """115200 baud of 16 MHz with U2X (16 + 1 eighths); both ways, with interrupts; 8N1."""
    assert run(world, ticks(1)).state["line"] == "16 2 152 6"


@pytest.mark.parametrize("behind", [b" ", b" 7", b"x7", b"\t;9"])
def test_what_stands_behind_a_checksum_is_no_part_of_it(world: Path, behind: bytes) -> None:
    line = numbered(1, "M105 *8").removesuffix(b"\n") + behind + b"\n"
    assert talk(world, numbered(0, "M110"), line).answers == ["ok", WARM]


@pytest.mark.parametrize("byte", [0, 1, 8, 11, 31, 127])
def test_what_no_line_has_makes_it_unreadable(world: Path, byte: int) -> None:
    said = talk(world, b"M105" + bytes([byte]) + b"\n", "M105")
    assert said.answers == ["echo:Unreadable line ignored", "ok", WARM]


@pytest.mark.parametrize("byte", [9, 32, 126, 128, 255])
def test_what_a_line_may_have(world: Path, byte: int) -> None:
    assert talk(world, b"M105 ;" + bytes([byte]) + b"\n").answers == [WARM]


def test_how_long_a_line_may_be(world: Path) -> None:
    assert talk(world, b"M105" + 92 * b" " + b"\n").answers == [WARM]
    too_long = ["echo:Line too long, ignored", "ok"]
    assert talk(world, b"M105" + 93 * b" " + b"\n").answers == too_long


def test_a_second_wait_is_like_the_first(world: Path) -> None:
    """Neither M108 nor the ticks at the temperature count for the next wait."""
    first = (celsius(200), received(b"M109 S200\n"), ticks(990), received(b"M108\n"), ticks(20))
    said = run(world, *first, received(b"M109 S200\n"), ticks(900))
    assert said.answers[-1] != "ok"
    said = run(world, *first, received(b"M109 S200\n"), ticks(1040))
    assert said.answers[-1] == "ok"
    assert run(world, received(b"M108\nM109 S200\n"), ticks(50)).answers == ["ok"]
