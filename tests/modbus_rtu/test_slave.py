"""The slave's C on this computer, in a world with two loops: against the oracle, and case by case
what happens on its line: bytes, flags, silences, and what follows."""

import math
import random
import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from rig.firmware import sources_of, spec_of
from rig.hosted import World, flagged, play, received, ticks, world_of
from rig.modbus_oracle import GAINS, MODES, Oracle
from suite import amount

from heatwright.sim.interfaces.modbus_rtu.frames import crc, framed

SLAVE = r"""
heatwright: 1
controller: {name: shape, title: '50 °C "of" \ ??/ {{ %s }}', board: mega2560}
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
    {sensor: air, heater: heater, period: 500 ms, autotune: {},
     algorithm: {kind: pid, kp: 8, ki: 0.05, kd: 30, derivative_filter: 4 s,
       integral: {maximum: 60 %}},
     setpoint: {initial: 20 °C, minimum: -5 °C, maximum: 250 °C},
     protection: {maximum: 280 °C, minimum: -10 °C, rise_rate: 20 K/s, frozen: off}}
  bed:
    {sensor: bed, heater: hot_bed, period: 1 s, response: {within: 2 K, for: 1 min},
     algorithm: {kind: on_off, hysteresis: 1 K},
     setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C},
     protection: {maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s, frozen: off}}
interfaces:
  - {kind: modbus_rtu, address: 17, baud: 1200, parity: odd, driver_enable: D37}
"""
"""A loop with gains, and one with a measured current and a measured response."""
ADDRESS = 17
LETTERS = {
    "fault": "f", "trips": "l", "fault_temperature": "F", "fault_time": "T", "uptime": "n",
    "air.missing": "m",
    "air.temperature": "t", "air.has_reading": "h", "air.reading": "r", "air.duty": "d",
    "air.setpoint_in_force": "c", "air.states": "S", "bed.states": "B", "air.tuning": "a",
    "bed.current": "A", "bed.temperature": "b", "bed.has_reading": "H", "bed.missing": "N",
    "bed.responses": "e", "bed.settling_time": "s", "bed.overshoot": "o",
}  # fmt: skip
"""Letters of world.c, by the names that the oracle knows them by."""


def slave_world() -> World:
    files = [name for name in sources_of(SLAVE) if re.fullmatch(r"modbus.*\.c", name)]
    return world_of(SLAVE, files, Path(__file__).with_name("world.c"))


# -- a script --------------------------------------------------------------------------------------


def frame(data: bytes) -> bytes:
    return b"f" + struct.pack("<H", len(data)) + data


def value(name: str, number: float) -> bytes:
    return b"v" + LETTERS[name].encode() + struct.pack("<f", number)


def run(slave: Path, script: Iterable[bytes]) -> list[bytes]:
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
        "04 00c8 000b",
    )
]  # fmt: skip
WORLDS: tuple[dict[str, float], ...] = (
    {"trips": 0},
    {"air.has_reading": 1, "air.temperature": 21.25, "air.duty": 37.5, "air.setpoint_in_force": 20,
     "air.states": 3, "bed.states": 1, "uptime": 70000, "bed.current": 3.456},
    {"air.temperature": -12.36, "air.missing": 1, "air.reading": 17, "air.duty": 100,
     "air.setpoint_in_force": -5, "air.states": 2, "air.tuning": 3, "bed.current": -0.5,
     "bed.has_reading": 1, "bed.temperature": 55.55, "bed.missing": 3, "trips": 3},
    {"air.missing": 0, "air.temperature": 4000, "fault_temperature": -4000, "fault_time": 100000,
     "uptime": 262144, "trips": 2, "bed.states": 12, "bed.current": 0.125, "bed.missing": 0,
     "bed.responses": 255, "bed.settling_time": 70000.5, "bed.overshoot": 2.25},
    {"air.temperature": 20.05, "air.states": 13, "uptime": 5, "fault_temperature": 285.44,
     "bed.current": 400, "bed.temperature": 0.06, "bed.missing": 1, "bed.responses": 1,
     "bed.settling_time": 0.1, "bed.overshoot": 0},
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
    answers = run(slave, play.script)
    if len(answers) != len(play.expected):
        return f"{len(answers)} answers, not {len(play.expected)}"
    for index, (got, want) in enumerate(zip(answers, play.expected, strict=True)):
        if got != want:
            asked = play.asked[index // 2].hex(" ")
            return f"{asked}: {('answers', 'then it is')[index % 2]} {got!r} instead of {want!r}"
    return ""


def shown(oracle: Oracle) -> bytes:
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


# -- requests by chance: right ones near the edges of a map, wrong lengths and values, damage ------

FUNCTIONS = (1, 2, 3, 4, 5, 6, 15, 16, 17, 22, 23, 43, 43, 16, 5)
ADDRESSES = (*range(-1, 4), *range(8, 18), *range(97, 110), *range(197, 213), 299, 300, 0x8000)
SHORT = (0, 1, 1, 1, 2, 2, 3, 4, 5, 6, 7, 8, 9)
COUNTS = (*SHORT, 16, 17, 121, 122, 123, 124, 125, 126, 1968, 2000, 2001)
WORDS = (
    0, 1, 99, 100, 199, 200, 201, 300, 301, 599, 700, 704, 705, 706, 800, 801, 999, 1000, 1001,
    2499, 2500, 2501, 3200, 3201, 0xFF00, 0xFFCE, 0xFFCD, 0x7FFF, 0x8000, 0x7FC0, 0x7F80, 0x4974,
    0x2400, 0x2401, 0x3F80, 0xBF80, 0xFFFF,
)  # fmt: skip
GAIN_VALUES = (0.0, -0.0, 0.1, 1e6, 1_000_000.0625, 1e9, -1e-3, math.inf, math.nan)
COILS = (0, 1, 2, 100, 100, 101, 102, 200)


def requests(
    seed: int, count: int, address: int, counts: Sequence[int] = COUNTS
) -> Iterator[bytes]:
    """Yield frames as they come in, CRC included; the same for the same seed."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    for _ in range(count):
        yield _frame(chance, address, counts)


def _frame(chance: random.Random, address: int, counts: Sequence[int]) -> bytes:
    kind = chance.random()
    if kind < 0.03:
        return chance.randbytes(chance.choice((1, 2, 3, 4, 5, 8, 40, 255, 256, 257, 300)))
    (to,) = chance.choices((address, 0, chance.randrange(256)), (90, 5, 5))
    body = bytes([to]) + pdu(chance, counts)
    if kind < 0.1:
        body = body[: chance.randrange(1, len(body) + 1)]
    elif kind < 0.15:
        body += chance.randbytes(chance.randrange(1, 4))
    frame = bytearray(body + crc(body))
    if 0.15 <= kind < 0.2:
        frame[chance.randrange(len(frame))] ^= 1 << chance.randrange(8)
    return bytes(frame)


def pdu(chance: random.Random, counts: Sequence[int] = COUNTS) -> bytes:
    if chance.random() < 0.4:
        return _apt(chance)
    function = chance.choice((*FUNCTIONS, chance.randrange(256)))
    first = chance.choice(ADDRESSES) & 0xFFFF
    counted = struct.pack(">HH", first, chance.choice(COUNTS))
    count = chance.choice((*range(1, 9), *counts))
    size = (count + 7) // 8
    second = struct.pack(">H", chance.choice(ADDRESSES) & 0xFFFF)
    bodies = {
        **dict.fromkeys((1, 2, 3, 4), counted),
        5: struct.pack(">HH", first, chance.choice((0, 0, 0xFF00, 0xFF00, 1, 0xFFFF))),
        6: struct.pack(">HH", first, chance.choice(WORDS)),
        15: struct.pack(">HH", first, count) + _sized(chance, chance.randbytes(min(size, 246))),
        16: struct.pack(">H", first) + _words(chance, chance.choice(counts)),
        17: b"",
        22: struct.pack(">HHH", first, chance.choice(WORDS), chance.choice(WORDS)),
        23: counted + second + _words(chance, min(chance.choice(counts), 121)),
        43: bytes([chance.choice((14, 14, 14, 14, 13)), chance.randrange(6), chance.randrange(7)]),
    }
    return bytes([function]) + bodies.get(function, chance.randbytes(chance.randrange(8)))


def _apt(chance: random.Random) -> bytes:
    on, coil = chance.choice((0, 0xFF00)), chance.choice(COILS)
    duty, kp = chance.choice((0, 1, 437, 999, 1000, 1001, 0xFFFF)), chance.choice(GAIN_VALUES)
    write_gain = struct.pack(">HHBf", chance.choice((102, 104, 106)), 2, 4, kp)
    some, many, block = chance.randrange(1, 4), chance.randrange(8), chance.choice((0, 100, 100))
    few = chance.randrange(1, some + 1)
    degrees = chance.choice((200, 9999))
    form, *values = chance.choice((
        ("BHH", 5, coil, on), ("BHH", 5, coil, on), ("BHH", 5, 100, on), ("BHH", 6, 101, duty),
        ("BHHBB", 15, 100, 3, 1, many), ("BHH", 6, 100, chance.randrange(3300)),
        ("BHHBB", 15, block + 3 - some, few, 1, chance.randrange(256)),
        ("BHH", 6, chance.choice((100, 200)), chance.choice(WORDS)), ("B9s", 16, write_gain),
        ("BHH9s", 23, 102, 2, write_gain), ("BHHBHHf", 16, 100, 4, 8, degrees, duty, kp),
        ("BHHHHBH", 23, 100, 8, 101, 1, 2, duty), ("BHHB3f", 16, 102, 6, 12, 0.5, kp, 1e6),
        ("BHHBHH3f", 16, 100, 8, 16, degrees, duty, kp, 0.0, 3),
        ("BHHB246x", 15, 100, 1722 + 246, 246), ("BHHB247x", 15, 100, 1722 + 247, 247),
    ))  # fmt: skip
    return struct.pack(f">{form}", *values)


def _sized(chance: random.Random, data: bytes) -> bytes:
    if chance.random() < 0.05:
        data = (data + bytes(3))[: max(0, len(data) + chance.choice((-1, 1, 2)))]
    return bytes([len(data) & 0xFF]) + data


def _words(chance: random.Random, count: int) -> bytes:
    values = [chance.choice(WORDS) for _ in range(min(count, 123))]
    return struct.pack(">H", count) + _sized(chance, struct.pack(f">{len(values)}H", *values))


SEEDS = 4
PARITY, OVERRUN, FRAMING = 1 << 2, 1 << 3, 1 << 4
SILENCE, MAIN, MAIN_ALONE, STATE = b"q", b"m", b"M", b"s"

ASK = framed(ADDRESS, bytes.fromhex("04 0000 0001"))
ANSWER = framed(ADDRESS, bytes.fromhex("04 02 0001"))
WRITE = framed(ADDRESS, struct.pack(">BHH", 6, 100, 300))
TO_ALL = framed(0, struct.pack(">BHH", 6, 100, 300))


def leaves(count: int) -> bytes:
    return b"p" + bytes([count])


END = SILENCE, MAIN, frame(ASK)
CASES: dict[str, tuple[tuple[bytes, ...], tuple[bytes, ...], tuple[int, ...]]] = {
    "no_silence": ((received(ASK), MAIN), (b"",), (0, 0, 0, 0, 0, 0, 0)),
    "silence": ((received(ASK), SILENCE, MAIN), (ANSWER,), (1, 0, 0, 1, 0, 0, 0)),
    "two_in_one": ((frame(ASK + ASK),), (b"",), (0, 1, 0, 0, 0, 0, 0)),
    **{f"{size}_foreign": ((frame(framed(9, bytes(size))), frame(ASK)), (b"", ANSWER),
                           (messages, 2 - messages, 0, 1, 0, 0, 0))
       for size, messages in ((253, 2), (254, 1))},
    **{f"{name}_at_{place}": (
        (received(ASK[:place]), flagged(flag, ASK[place]), received(ASK[place + 1 :]), *END),
        (b"", ANSWER), (1, 1, 0, 1, 0, int(flag == OVERRUN), 0))
       for name, flag in (("parity", PARITY), ("overrun", OVERRUN), ("framing", FRAMING))
       for place in (0, 5, 7)},
    "while_to_all_waits": (
        (received(TO_ALL), SILENCE, received(ASK[:3]), MAIN, received(ASK[3:]), *END),
        (b"", b"", ANSWER), (2, 1, 0, 2, 1, 0, 0)),
    **{name: ((received(WRITE), SILENCE, *script, *END), (WRITE, ANSWER), (2, 0, 0, 2, 0, 0, 0))
       for name, script in {
           "while_it_is_asked": [received(ASK)],
           "while_it_answers": [MAIN_ALONE, leaves(3), received(ASK)],
           "silence_while_it_answers": [received(ASK[:1]), MAIN_ALONE, leaves(3)],
           "damaged_while_asked": [flagged(OVERRUN, 1)],
       }.items()},
    "noise_behind_a_frame": (
        (received(WRITE), flagged(FRAMING, 0), *END), (b"", ANSWER), (1, 1, 0, 1, 0, 0, 0)),
    "damage_after_overrun": (
        (flagged(OVERRUN, 1), SILENCE, flagged(PARITY, 1), SILENCE, frame(ASK)),
        (ANSWER,), (1, 2, 0, 1, 0, 1, 0)),
    "ticks": ((ticks(7), frame(ASK), ticks(5)), (ANSWER,), (1, 0, 0, 1, 0, 0, 5)),
}  # fmt: skip


@pytest.fixture(scope="session")
def slave() -> Path:
    return slave_world().sanitized().program()


@pytest.mark.parametrize("seed", range(SEEDS))
def test_it_answers_as_documented(slave: Path, seed: int) -> None:
    assert played(slave, fuzz(seed, amount("modbus_frames_host") // SEEDS)) == ""


@pytest.mark.parametrize(("script", "sent", "counters"), CASES.values(), ids=CASES)
def test_the_line(
    slave: Path, script: tuple[bytes, ...], sent: tuple[bytes, ...], counters: tuple[int, ...]
) -> None:
    """What is sent for each frame and MAIN; messages, errors, exceptions, requests, unanswered and
    overruns; and the ticks of silence."""
    state, *answers, last = run(slave, [STATE, *script, STATE])
    assert tuple(answers) == sent
    assert tuple(map(int, last.split()[16:-1])) == counters
    if not any(WRITE in part or TO_ALL in part for part in script):
        assert last.split()[:15] == state.split()[:15]


def test_a_silence_is_counted_to_its_largest_number_and_no_further(slave: Path) -> None:
    (state,) = run(slave, [ticks(60_000), ticks(60_000), STATE])
    assert state.split()[-2:] == [b"65535", b"0"]


def test_the_line_is_set_up(slave: Path) -> None:
    """1200 baud of 16 MHz with U2X (1666 + 1 eighths), 8O1, timer 2 at clock / 1024 and nothing
    else, the receiver's pin an input that is pulled up."""
    assert run(slave, [b"l"]) == [bytes((0x82, 0x06, 2, 0x36, 0, 7, 1, 0))]
