"""The generated Modbus files on this computer, in a world with two loops: scripts for it, and what
it has to say to them by the oracle."""

import re
import struct
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from modbus_requests import requests
from rig.hosted import World, play, world_of
from rig.modbus_oracle import GAINS, MODES, Oracle
from rig.specs import sources_of, spec_of

from heatwright.sim.interfaces.modbus_frames import framed

SLAVE = """
heatwright: 1
controller: {name: shape, title: 'Shape "of" 50 °C', board: mega2560}
sensors:
  air: {kind: thermistor, pin: A1, divider: {pull_up: 4.7 kΩ}, oversample: 4,
    curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: -20 °C .. 300 °C}
  bed: {kind: thermistor, pin: A3, divider: {pull_up: 4.7 kΩ}, oversample: 4,
    curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: -20 °C .. 300 °C}
  shunt: {kind: current, pin: A4, scale: 0.2 V/A}
outputs:
  heater: {kind: pwm, pin: D46, frequency: 100 Hz, power: 40 W}
  hot_bed: {kind: digital, pin: D22, power: 100 W, supply: 24 V,
    current: {sensor: shunt, trip: 6 A}}
loops:
  air:
    sensor: air
    heater: heater
    period: 500 ms
    algorithm: {kind: pid, kp: 8, ki: 0.05, kd: 30, derivative_filter: 4 s,
      integral: {maximum: 60 %}}
    autotune: {}
    setpoint: {initial: 20 °C, minimum: -5 °C, maximum: 250 °C}
    protection: {maximum: 280 °C, minimum: -10 °C, rise_rate: 20 K/s, frozen: off}
  bed:
    sensor: bed
    heater: hot_bed
    period: 1 s
    algorithm: {kind: on_off, hysteresis: 1 K}
    setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}
    protection: {maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s, frozen: off}
interfaces:
  - {kind: modbus_rtu, address: 17, baud: 1200, parity: odd, driver_enable: D37}
"""
"""A loop with gains and one with a measured current."""
ADDRESS = 17
LETTERS = {
    "fault": "f", "fault_temperature": "F", "fault_time": "T", "uptime": "n", "air.missing": "m",
    "air.temperature": "t", "air.has_reading": "h", "air.reading": "r", "air.duty": "d",
    "air.setpoint_in_force": "c", "air.states": "S", "bed.states": "B", "air.tuning": "a",
    "bed.current": "A", "bed.temperature": "b", "bed.has_reading": "H", "bed.missing": "N",
}  # fmt: skip
"""Of world.c, by the names that the oracle knows them by."""


def slave_world() -> World:
    """Return the slave's files in their world."""
    files = [name for name in sources_of(SLAVE) if re.fullmatch(r"modbus.*\.c", name)]
    return world_of(SLAVE, files, Path(__file__).with_name("world.c"))


# -- a script --------------------------------------------------------------------------------------


def frame(data: bytes) -> bytes:
    """A frame comes in, with silence behind it, and is answered."""
    return b"f" + struct.pack("<H", len(data)) + data


def received(data: bytes) -> bytes:
    """Bytes come in."""
    return b"r" + struct.pack("<H", len(data)) + data


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


def value(name: str, number: float) -> bytes:
    return b"v" + LETTERS[name].encode() + struct.pack("<f", number)


def run(slave: Path, script: Iterable[bytes]) -> list[bytes]:
    """Play a script; return what came out, piece by piece."""
    pieces, rest = [], memoryview(play(slave, script))
    while rest:
        size = rest[0] | rest[1] << 8
        pieces.append(bytes(rest[2 : 2 + size]))
        rest = rest[2 + size :]
    return pieces


# -- by the oracle ---------------------------------------------------------------------------------

READ_ALL = [
    bytes.fromhex(text)
    for text in (
        "01 0000 0003", "01 0064 0003", "01 00c8 0001", "02 0000 0001", "02 0064 0005",
        "02 00c8 0005", "03 0064 0008", "03 00c8 0001", "04 0000 0010", "04 0064 0007",
        "04 00c8 0006",
    )
]  # fmt: skip
WORLDS: tuple[dict[str, float], ...] = (
    {},
    {"air.has_reading": 1, "air.temperature": 21.25, "air.duty": 37.5, "air.setpoint_in_force": 20,
     "air.states": 3, "bed.states": 1, "uptime": 70000, "bed.current": 3.456},
    {"air.temperature": -12.36, "air.missing": 1, "air.reading": 17, "air.duty": 100,
     "air.setpoint_in_force": -5, "air.states": 2, "air.tuning": 3, "bed.current": -0.5,
     "bed.has_reading": 1, "bed.temperature": 55.55, "bed.missing": 3},
    {"air.missing": 0, "air.temperature": 4000, "fault_temperature": -4000, "fault_time": 100000,
     "uptime": 262144, "bed.states": 12, "bed.current": 0.125, "bed.missing": 0},
    {"air.temperature": 20.05, "air.states": 13, "uptime": 5, "fault_temperature": 285.44,
     "bed.current": 400, "bed.temperature": 0.06, "bed.missing": 1},
)  # fmt: skip
"""What changes about the slave, round by round."""
FAULTS = (0, 1, 22)


class Play(NamedTuple):
    """What is said to the slave, and what it has to answer."""

    script: tuple[bytes, ...]
    asked: tuple[bytes, ...]
    expected: tuple[bytes, ...]
    """To each that is asked the answer, and the state afterwards."""


def written(steps: Iterable[bytes | tuple[str, float]]) -> Play:
    """Let the oracle answer frames, in a world that others change."""
    oracle = Oracle(spec_of(SLAVE).controller)
    script, asked, expected = [], [], []
    for step in steps:
        if isinstance(step, bytes):
            script += [frame(step), b"s"]
            asked.append(step)
            expected += [oracle.hear(step), shown(oracle)]
            continue
        name, number = step
        script.append(value(name, number))
        if name == "fault":
            oracle.fault = int(number)
        else:
            oracle.world[name] = number
    return Play(tuple(script), tuple(asked), tuple(expected))


def played(slave: Path, play: Play) -> str:
    """Say where the slave differs from the oracle; an empty text if nowhere."""
    answers = run(slave, play.script)
    if len(answers) != len(play.expected):
        return f"{len(answers)} answers, not {len(play.expected)}"
    for index, (got, want) in enumerate(zip(answers, play.expected, strict=True)):
        if got != want:
            asked = play.asked[index // 2].hex(" ")
            return f"{asked}: {('answers', 'then it is')[index % 2]} {got!r} instead of {want!r}"
    return ""


def shown(oracle: Oracle) -> bytes:
    """What world.c shows of the state after each frame."""
    air, bed = oracle.loops["air"], oracle.loops["bed"]
    calls = [oracle.calls["store"], oracle.calls["restore"], oracle.calls["tune"] & 0xFF]
    counters = [count & 0xFFFF for count in oracle.counters.values()]
    numbers = [
        oracle.fault, oracle.acknowledged & 0xFF, air.setpoint, air.enabled, air.released,
        MODES.index(air.mode), air.manual_duty, *(air.gains[gain] for gain in GAINS), bed.setpoint,
        bed.enabled, bed.released, *calls, *counters, 0, oracle.counters["requests"] > 0,
    ]  # fmt: skip
    return " ".join(f"{number:.9g}" for number in numbers).encode()


@cache
def fuzz(seed: int, count: int) -> Play:
    """Frames, and now and then another world, a fault, and a reading of everything."""
    return written(_steps(seed, count))


def _steps(seed: int, count: int) -> Iterator[bytes | tuple[str, float]]:
    for index, each in enumerate(requests(seed, count, ADDRESS)):
        if index % 50 == 0:
            yield from WORLDS[index // 50 % len(WORLDS)].items()
            if index % 200 == 0:
                yield ("fault", float(FAULTS[index // 200 % 3]))
            for pdu in READ_ALL:
                yield framed(ADDRESS, pdu)
        yield each
