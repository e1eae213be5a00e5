"""Anything a line can bring, on this computer: it does no harm, and a good line is answered."""

import random
from pathlib import Path

from gcode_world import celsius, fault, numbered, received, run, ticks, tuning_ends
from suite import amount


def session(seed: int) -> list[bytes]:
    """Anything a line can bring: noise, near misses, commands, numbers out of any bounds."""
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


WAKE_UP = [
    received(b"\n"), ticks(50), received(b"M108\n"), ticks(500), tuning_ends(4), ticks(500),
    received(b"\n"), ticks(50), received(b"M999\n"), ticks(50), received(b"M105\n"), ticks(50),
]  # fmt: skip


def session_problem(world: Path, seed: int) -> str:
    """Say whether a session ends without a good answer, or beyond a limit."""
    said = run(world, *session(seed), *WAKE_UP)
    setpoint, fan = float(said.state["setpoint"]), float(said.state["fan"])
    gains = [float(gain) for gain in said.state["gains"].split()]
    if not said.answers[-1].startswith("ok T:"):
        return f"session {seed}: {said.answers[-1]}"
    allowed = 0 <= setpoint <= 260 and 0 <= fan <= 100 and all(0 <= gain <= 1e6 for gain in gains)
    return "" if allowed else f"session {seed}: {said.state}"


def test_whatever_comes_a_good_line_is_answered_afterwards(world: Path) -> None:
    """Nothing undefined is done (the sanitizers end the program), and no limit is passed."""
    for seed in range(amount("gcode_sessions")):
        assert session_problem(world, seed) == ""
