"""One script for slave and model, and where they differ."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from slave_frames import frames
from slave_model import Slave, framed
from slave_spec import ADDRESS, SLAVE
from slave_world import frame, run, value

from heatwright.spec import load_text

READ_ALL = [
    bytes.fromhex(text)
    for text in (
        "01 0000 0003", "01 0064 0003", "01 00c8 0001", "02 0000 0001", "02 0064 0005",
        "02 00c8 0005", "03 0064 0008", "03 00c8 0001", "04 0000 0010", "04 0064 0007",
        "04 00c8 0006",
    )
]  # fmt: skip

# Of the world: what stands there, by the letter of world.c, round by round.
WORLDS: tuple[dict[str, float], ...] = (
    {},
    {"h": 1, "t": 21.25, "d": 37.5, "c": 20, "S": 3, "B": 1, "n": 70000, "A": 3.456},
    {"h": 1, "t": -12.34, "m": 1, "r": 17, "d": 100, "c": -5, "S": 2, "a": 3, "A": -0.5},
    {"h": 1, "t": 4000, "F": -4000, "T": 100000, "n": 262144, "B": 12, "A": 0.125},
    {"h": 1, "t": 20.05, "S": 13, "n": 5, "F": 285.44, "A": 400},
)


def model() -> Slave:
    spec = load_text(SLAVE)
    identity = spec.controller.identity
    return Slave(int(spec.digest, 16), identity.name, identity.title or identity.name)


class Play(NamedTuple):
    """What is said to the slave, and what it has to answer."""

    script: tuple[bytes, ...]
    asked: tuple[bytes, ...]
    expected: tuple[bytes, ...]
    """To each that is asked the answer, and the state afterwards."""


def written(steps: Iterable[bytes | tuple[str, float]]) -> Play:
    """Let the model answer frames, in a world that others change."""
    slave = model()
    script, asked, expected = [], [], []
    for step in steps:
        if isinstance(step, bytes):
            script += [frame(step), b"s"]
            asked.append(step)
            expected += [slave.frame(step), shown(slave)]
        else:
            what, number = step
            script.append(value(what, number))
            _tell(slave, what, number)
    return Play(tuple(script), tuple(asked), tuple(expected))


def played(program: Path, play: Play) -> str:
    """Say where the slave differs from the model; an empty text if nowhere."""
    answers = run(program, play.script)
    if len(answers) != len(play.expected):
        return f"{len(answers)} answers, not {len(play.expected)}"
    for index, (got, want) in enumerate(zip(answers, play.expected, strict=True)):
        if got != want:
            return f"{play.asked[index // 2].hex(' ')}: {got!r} instead of {want!r}"
    return ""


def _tell(slave: Slave, what: str, number: float) -> None:
    if what == "f":
        slave.fault = int(number)
    elif what == "M":
        slave.air.mode = int(number)
    else:
        slave.world[what] = number


def shown(slave: Slave) -> bytes:
    """What world.c shows of the state after each frame."""
    air, bed, counters = slave.air, slave.bed, slave.counters.values()
    heard = int(slave.counters["requests"] > 0)
    numbers = [
        slave.fault, slave.acknowledged & 0xFF, air.setpoint, int(air.enabled), int(air.released),
        air.mode, air.percent, *air.gains, bed.setpoint, int(bed.enabled), int(bed.released),
        slave.kept, slave.defaulted, slave.cycles, *(count & 0xFFFF for count in counters), 0,
        heard,
    ]  # fmt: skip
    return " ".join(f"{number:.9g}" for number in numbers).encode()


def fuzz(seed: int, count: int) -> Iterator[bytes | tuple[str, float]]:
    """Yield frames, and now and then another world, a fault, and a reading of everything."""
    for index, each in enumerate(frames(seed, count)):
        if index % 50 == 0:
            world = WORLDS[index // 50 % len(WORLDS)]
            yield from world.items()
            if index % 200 == 0:
                yield ("f", float(index // 200 % 3 * 11))
            for pdu in READ_ALL:
                yield framed(ADDRESS, pdu)
        yield each
