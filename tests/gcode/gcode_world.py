"""A G-code board to talk with: its files on this computer, in a world with one tool, nozzle, and
one fan; and its binary in the simulator."""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import xor
from pathlib import Path

from rig.firmware import device_of, sources_of
from rig.hosted import World, play, received, ticks, world_of

from heatwright.sim.interfaces.gcode import GcodeHost

TICKS_PER_S = 100


def gcode_world(spec: str = "extruder") -> World:
    """Return the files that a host speaks with, of a spec's text or an example."""
    files = [name for name in sources_of(spec) if re.fullmatch(r"(gcode.*|host|text)\.c", name)]
    return world_of(spec, files, Path(__file__).with_name("world.c"))


def celsius(value: float, of: str = "nozzle") -> bytes:
    return {"nozzle": b"c", "bed": b"b"}[of] + struct.pack("<f", value)


def setpoint_becomes(degrees: int) -> bytes:
    return b"s" + struct.pack("<H", degrees)


def switched(times: int) -> bytes:
    """How often the relay of a tuning has switched on."""
    return b"w" + bytes([times])


def tuning_ends(result: int) -> bytes:
    return b"a" + bytes([result])


def fault(code: int) -> bytes:
    return b"f" + bytes([code])


def numbered(number: int, line: str, begin: str = "N") -> bytes:
    text = f"{begin}{number} {line}".encode()
    return text + b"*%d\n" % reduce(xor, text)


@dataclass(frozen=True)
class Said:
    """What was answered, and how things stood at the end."""

    lines: list[str]
    state: dict[str, str]

    @property
    def answers(self) -> list[str]:
        assert self.lines[0] == "start"
        return self.lines[2:]


def run(program: Path, *script: bytes) -> Said:
    said, _, state = play(program, script).partition(b"=setpoint ")
    pairs = [line.split(" ", 1) for line in f"setpoint {state.decode()}".splitlines()]
    states = {name.lstrip("="): value for name, value in pairs}
    return Said(said.decode("ascii").splitlines(), states)


def spoken(*lines: str | bytes) -> list[bytes]:
    script = [ticks(10)]
    for line in lines:
        script += [received(line if isinstance(line, bytes) else f"{line}\n".encode()), ticks(12)]
    return script


def talk(program: Path, *lines: str | bytes) -> Said:
    return run(program, *spoken(*lines))


class Board:
    """A board on whose serial line a test goes on line by line.

    lines -- all that was said; tell -- send a line as a person does, and wait; steps -- where the
    feed is.
    """

    lines: Callable[[], list[str]]
    tell: Callable[..., None]
    wait: Callable[[float], None]
    sense: Callable[[str, float], None]
    _known = 0

    def told(self, line: str, seconds: float = 0.5) -> list[str]:
        self.heard()
        self.tell(line, seconds)
        return self.heard()

    def heard(self) -> list[str]:
        lines = self.lines()
        known, self._known = self._known, len(lines)
        return lines[known:]


class HostBoard(Board):
    """The firmware on this computer, in whose world a test goes on line by line.

    What has happened so far is played again for each answer: the world has no other memory.
    """

    def __init__(self, program: Path, *begin: bytes) -> None:
        self._program, self._script = program, [*begin, ticks(TICKS_PER_S)]
        self._played: list[bytes] = []
        self.heard()

    def said(self) -> Said:
        if self._played != self._script:
            self._played = list(self._script)
            self._said = run(self._program, *self._script)
        return self._said

    def lines(self) -> list[str]:
        return self.said().lines

    def tell(self, line: str, seconds: float = 0.5) -> None:
        self._script.append(received(line.encode() + b"\n"))
        self.wait(seconds)

    def sense(self, sensor: str, degrees: float) -> None:
        self.play(celsius(degrees, sensor))

    def play(self, *script: bytes) -> None:
        self._script += script

    def wait(self, seconds: float) -> None:
        self._script.append(ticks(round(TICKS_PER_S * seconds)))

    @property
    def steps(self) -> int:
        return int(self.said().state["feed"].split()[0])

    @property
    def motor_is_free(self) -> bool:
        return self.said().state["feed"].split()[2] != "0"


class BinaryBoard(Board):
    """The firmware's binary; device -- the board itself."""

    def __init__(self, spec: str, **celsius: float) -> None:
        self.device = device_of(spec)
        for sensor, degrees in celsius.items():
            self.sense(sensor, degrees)
        self.wait(1.0)
        self.heard()

    @property
    def host(self) -> GcodeHost:
        return self.device.host

    def lines(self) -> list[str]:
        return [line.text for line in self.host.lines]

    def tell(self, line: str, seconds: float = 0.5) -> None:
        self.host.send_bytes(line.encode() + b"\n")
        self.wait(seconds)

    def sense(self, sensor: str, degrees: float) -> None:
        self.device.sense(sensor, degrees)

    def wait(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)

    def on_fraction(self, output: str, seconds: float = 2.0) -> float:
        self.device.on_fraction(output)
        self.wait(seconds)
        return self.device.on_fraction(output)

    @property
    def steps(self) -> int:
        self.device.feed()
        return int(self.device.outputs["feed"].position)

    @property
    def motor_is_free(self) -> bool:
        return self.on_fraction("feed", 1.0) == 0.0


def ready(feeder: Board) -> Board:
    assert feeder.told("M104 S200", 1.0) == ["ok"]
    return feeder
