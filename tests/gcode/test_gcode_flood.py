"""What the receive interrupt does: it stops at once, marks damage, and drops what does not fit."""

from pathlib import Path

import pytest
from gcode_world import celsius, run
from rig.hosted import flagged, received, ticks


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


LOOK_ALIKES = (
    b"M1120\n", b"M11\n", b"M12\n", b"XM112\n", b"; M112\n", b"M117 M112\n", b"M112.5\n",
    b"N5 N6 M112\n", b"GM112\n", b"M1 12\n", b"N5;M112\n", b"M65648\n", b"M112",
    b"M104 S112\n", b"N112\n", b"-M112\n", b"M\x80112\n", b"M-112\n", b"X112\n", b"N5X112\n",
    b"N5 X112\n", b"N/M112\n", b"N:M112\n", b"N5,M112\n", b"N5 5M112\n", b"M10<\n", b"M9F\n",
    b"M13\x1e\n", b"M:2\n", b"M1M112\n", b"MM112\n", b"M1<M112\n", b"N5N112\n", b"N5NM112\n",
    b"N5  5M112\n", b"N5  N6M112\n", b"N5 N112\n", b"N5 NM112\n", b" 5M112\n", b"X\tM112\n",
)  # fmt: skip
URGENT = (b"M112\nM108\n", b"M108\nM112\n", b"M112\nM410\n", b"M410\nM112\n")
WAITS = celsius(20) + received(b"M109 S200\n") + ticks(20)


@pytest.mark.parametrize(
    ("before", "line", "stopped"),
    [
        *((b"", line, "0") for line in LOOK_ALIKES),
        *((WAITS + received(300 * b";"), b"\n" + lines, "19") for lines in URGENT),
        (b"", 5000 * b"M105 " + b"\nM112\n", "19"),
    ],
    ids=[*map(repr, (*LOOK_ALIKES, *URGENT)), "in a flood that overflows"],
)
def test_nothing_but_m112_stops_and_nothing_displaces_it(
    world: Path, before: bytes, line: bytes, stopped: str
) -> None:
    assert run(world, before, received(line), ticks(1)).state["fault"] == stopped


def test_what_did_not_fit_is_not_done_by_halves(world: Path) -> None:
    """The lines of a flood are done whole, or not: no S2 from the beginning of S200."""
    for length in range(200, 270):
        flood = b";" * (length - 1) + b"\n" + 3 * b"M104 S200\n"
        said = run(world, received(flood), ticks(40), received(b"\nM105\n"), ticks(20))
        assert ("echo:Unreadable line ignored" in said.answers) is (len(flood) > 254)
        assert said.state["setpoint"] in {"0", "200"}
        assert said.answers[-1].startswith("ok T:")


@pytest.mark.parametrize("flag", [1 << 4, 1 << 3], ids=["framing", "overrun"])
def test_a_damaged_byte_is_never_taken_for_another(world: Path, flag: int) -> None:
    for at in range(4):
        damaged = flagged(flag, b"M112"[at])
        script = (received(b"M112"[:at]), damaged, received(b"M112"[at + 1 :] + b"\n"), ticks(20))
        said = run(world, *script)
        assert said.state["fault"] == "0"
        assert said.answers == ["echo:Unreadable line ignored", "ok"]
