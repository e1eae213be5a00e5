"""Requests by chance: right ones near the edges of a map, wrong lengths and values, damage."""

import math
import random
import struct
from collections.abc import Iterator, Sequence

from heatwright.sim.interfaces.modbus_frames import crc

FUNCTIONS = (1, 2, 3, 4, 5, 6, 15, 16, 17, 22, 23, 43, 43, 16, 5)
ADDRESSES = (*range(-1, 4), *range(8, 18), *range(97, 110), *range(197, 208), 299, 300, 0x8000)
SHORT = (0, 1, 1, 1, 2, 2, 3, 4, 5, 6, 7, 8, 9)
COUNTS = (*SHORT, 16, 17, 121, 122, 123, 124, 125, 126, 1968, 2000, 2001)
WORDS = (
    0, 1, 99, 100, 199, 200, 201, 300, 301, 599, 700, 704, 705, 706, 800, 801, 999, 1000, 1001,
    2499, 2500, 2501, 3200, 3201, 0xFF00, 0xFFCE, 0xFFCD, 0x7FFF, 0x8000, 0x7FC0, 0x7F80, 0x4974,
    0x2400, 0x2401, 0x3F80, 0xBF80, 0xFFFF,
)  # fmt: skip
GAINS = (0.0, -0.0, 0.1, 1e6, 1_000_000.0625, 1e9, -1e-3, math.inf, math.nan)
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
    """Return a request, often one that may be served."""
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
    """Choose what a master says that knows the map."""
    on, coil = chance.choice((0, 0xFF00)), chance.choice(COILS)
    duty, kp = chance.choice((0, 1, 437, 999, 1000, 1001, 0xFFFF)), chance.choice(GAINS)
    write_gain = struct.pack(">HHBf", chance.choice((102, 104, 106)), 2, 4, kp)
    some, many, block = chance.randrange(1, 4), chance.randrange(8), chance.choice((0, 100, 100))
    few, size = chance.randrange(1, some + 1), chance.choice((246, 247))
    return chance.choice(
        (
            struct.pack(">BHH", 5, coil, on),
            struct.pack(">BHH", 5, coil, on),
            struct.pack(">BHHBB", 15, 100, 3, 1, many),
            struct.pack(">BHHBB", 15, block + 3 - some, few, 1, chance.randrange(256)),
            struct.pack(">BHH", 5, 100, on),
            struct.pack(">BHH", 6, 101, duty),
            struct.pack(">BHH", 6, 100, chance.randrange(3300)),
            struct.pack(">BHH", 6, chance.choice((100, 200)), chance.choice(WORDS)),
            b"\x10" + write_gain,
            struct.pack(">BHHBHHf", 16, 100, 4, 8, chance.choice((200, 9999)), duty, kp),
            struct.pack(">BHHHHBH", 23, 100, 8, 101, 1, 2, duty),
            struct.pack(">BHH", 23, 102, 2) + write_gain,
            struct.pack(">BHHB3f", 16, 102, 6, 12, 0.5, kp, 1e6),
            struct.pack(">BHHBHH3f", 16, 100, 8, 16, chance.choice((200, 9999)), duty, kp, 0.0, 3),
            struct.pack(">BHHB", 15, 100, 1722 + size, size) + bytes(size),
        )
    )


def _sized(chance: random.Random, data: bytes) -> bytes:
    """Put its size before data; now and then another one, and data that go with that."""
    if chance.random() < 0.05:
        data = (data + bytes(3))[: max(0, len(data) + chance.choice((-1, 1, 2)))]
    return bytes([len(data) & 0xFF]) + data


def _words(chance: random.Random, count: int) -> bytes:
    values = [chance.choice(WORDS) for _ in range(min(count, 123))]
    return struct.pack(">H", count) + _sized(chance, struct.pack(f">{len(values)}H", *values))
