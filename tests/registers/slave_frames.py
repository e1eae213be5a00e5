"""Frames of every kind: right ones near the edges of the map, wrong lengths, damage, noise."""

import math
import random
import struct
from collections.abc import Iterator

from slave_model import crc16
from slave_spec import ADDRESS

ADDRESSES = (*range(-1, 4), *range(8, 18), *range(97, 110), *range(197, 208), 299, 300, 0x8000)
COUNTS = (
    0,
    1,
    1,
    1,
    2,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
    16,
    17,
    121,
    122,
    123,
    124,
    125,
    126,
    1968,
    2000,
    2001,
)
WORDS = (
    0, 1, 199, 200, 201, 300, 704, 705, 706, 999, 1000, 1001, 2499, 2500, 2501, 0xFF00, 0xFFCE,
    0xFFCD, 0x7FFF, 0x8000, 0x7FC0, 0x7F80, 0x4974, 0x2400, 0x2401, 0x3F80, 0xFFFF,
)  # fmt: skip


def frames(seed: int, count: int) -> Iterator[bytes]:
    """Yield frames as they come in, CRC included; the same for the same seed."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    for _ in range(count):
        yield _frame(chance)


def _frame(chance: random.Random) -> bytes:
    kind = chance.random()
    if kind < 0.03:
        return chance.randbytes(chance.choice((1, 2, 3, 4, 5, 8, 40, 255, 256, 257, 300)))
    address = chance.choices((ADDRESS, 0, chance.randrange(256)), (90, 5, 5))[0]
    body = bytes([address]) + _pdu(chance)
    if kind < 0.1:
        body = body[: chance.randrange(1, len(body) + 1)]
    elif kind < 0.15:
        body += chance.randbytes(chance.randrange(1, 4))
    frame = bytearray(body + crc16(body))
    if 0.15 <= kind < 0.2:
        place = chance.randrange(len(frame))
        frame[place] ^= 1 << chance.randrange(8)
    return bytes(frame)


def _pdu(chance: random.Random) -> bytes:
    function = chance.choice(
        (1, 2, 3, 4, 5, 6, 15, 16, 17, 22, 23, 43, 43, 16, 5, chance.randrange(256))
    )
    first = chance.choice(ADDRESSES) & 0xFFFF
    head = bytes([function])
    if chance.random() < 0.4:
        return _apt(chance)
    counted = struct.pack(">HH", first, chance.choice(COUNTS))
    count = chance.choice((*range(1, 9), *COUNTS))
    size = (count + 7) // 8
    bodies = {
        **dict.fromkeys((1, 2, 3, 4), counted),
        5: struct.pack(">HH", first, chance.choice((0, 0, 0xFF00, 0xFF00, 1, 0xFFFF))),
        6: struct.pack(">HH", first, chance.choice(WORDS)),
        15: struct.pack(">HH", first, count) + _sized(chance, chance.randbytes(min(size, 246))),
        16: struct.pack(">H", first) + _words(chance, chance.choice(COUNTS)),
        17: b"",
        22: struct.pack(">HHH", first, chance.choice(WORDS), chance.choice(WORDS)),
        23: counted
        + struct.pack(">H", chance.choice(ADDRESSES) & 0xFFFF)
        + _words(chance, min(chance.choice(COUNTS), 121)),
        43: bytes([chance.choice((14, 14, 14, 14, 13)), chance.randrange(6), chance.randrange(7)]),
    }
    other = chance.randbytes(chance.randrange(8))
    return head + bodies.get(function, other)


def _apt(chance: random.Random) -> bytes:
    """Choose what a master says that knows the map."""
    on, coil = chance.choice((0, 0xFF00)), chance.choice((0, 1, 2, 100, 100, 101, 102, 200))
    duty, kp = chance.choice((0, 1, 437, 999, 1000, 1001)), chance.choice(GAINS)
    write_gain = struct.pack(">HHBf", chance.choice((102, 104, 106)), 2, 4, kp)
    some, many = chance.randrange(1, 4), chance.randrange(8)
    return chance.choice(
        (
            struct.pack(">BHH", 5, coil, on),
            struct.pack(">BHH", 5, coil, on),
            struct.pack(">BHHBB", 15, 100, 3, 1, many),
            struct.pack(">BHHBB", 15, 103 - some, some, 1, chance.randrange(256)),
            struct.pack(">BHH", 6, 101, duty),
            struct.pack(">BHH", 6, chance.choice((100, 200)), chance.choice(WORDS)),
            b"\x10" + write_gain,
            struct.pack(">BHHBHHf", 16, 100, 4, 8, chance.choice((200, 9999)), duty, kp),
            struct.pack(">BHHHHBH", 23, 100, 8, 101, 1, 2, duty),
            struct.pack(">BHH", 23, 102, 2) + write_gain,
        )
    )


GAINS = (0.0, -0.0, 0.1, 1e6, 1_000_000.0625, 1e9, -1e-3, math.inf, math.nan)


def _sized(chance: random.Random, data: bytes) -> bytes:
    """Put its size before data; now and then another one, and data that go with that."""
    if chance.random() < 0.05:
        data = (data + bytes(3))[: max(0, len(data) + chance.choice((-1, 1, 2)))]
    return bytes([len(data) & 0xFF]) + data


def _words(chance: random.Random, count: int) -> bytes:
    values = [chance.choice(WORDS) for _ in range(min(count, 123))]
    return struct.pack(">H", count) + _sized(chance, struct.pack(f">{len(values)}H", *values))
