"""The generated G-code files on this computer, in a world with one tool, nozzle, and one fan."""

import struct
from dataclasses import dataclass
from functools import reduce
from operator import xor
from pathlib import Path

from rig.hosted import World, play, world_of
from rig.specs import sources_of

MINE = ("gcode", "host.", "text.")


def gcode_world() -> World:
    """Return the extruder's files that a host speaks with."""
    files = [name for name in sources_of("extruder") if name.startswith(MINE)]
    mine = [name for name in files if name.endswith(".c")]
    return world_of("extruder", mine, Path(__file__).with_name("world.c"))


def received(data: bytes) -> bytes:
    """Bytes that come in."""
    parts = [data[i : i + 0xFFFF] for i in range(0, len(data), 0xFFFF)]
    return b"".join(b"r" + struct.pack("<H", len(part)) + part for part in parts)


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


def celsius(value: int) -> bytes:
    return b"c" + struct.pack("<h", value)


def tuning_ends(result: int) -> bytes:
    return b"a" + bytes([result])


def fault(code: int) -> bytes:
    return b"f" + bytes([code])


def numbered(number: int, line: str) -> bytes:
    """A line with its number and checksum."""
    text = f"N{number} {line}".encode()
    return text + b"*%d\n" % reduce(xor, text)


@dataclass(frozen=True)
class Said:
    """What was answered, and how things stood at the end."""

    lines: list[str]
    state: dict[str, str]

    @property
    def answers(self) -> list[str]:
        """Without the greeting."""
        assert self.lines[0] == "start"
        return self.lines[2:]


def run(program: Path, *script: bytes) -> Said:
    """Play a script."""
    said, _, state = play(program, script).partition(b"=setpoint ")
    pairs = [line.split(" ", 1) for line in f"setpoint {state.decode()}".splitlines()]
    return Said(
        said.decode("ascii").splitlines(), {name.lstrip("="): value for name, value in pairs}
    )


def talk(program: Path, *lines: str | bytes, wait: int = 12) -> Said:
    """Send lines one by one, each with time for its answer."""
    script = [ticks(10)]
    for line in lines:
        data = line if isinstance(line, bytes) else f"{line}\n".encode()
        script += [received(data), ticks(wait)]
    return run(program, *script)
