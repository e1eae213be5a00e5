"""Frames of every kind: right ones near the edges of the map, wrong lengths, damage, noise."""

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
    counted = struct.pack(">HH", first, chance.choice(COUNTS))
    count = chance.choice((*range(1, 9), *COUNTS))
    size = (count + 7) // 8
    bodies = {
        **dict.fromkeys((1, 2, 3, 4), counted),
        5: struct.pack(">HH", first, chance.choice((0, 0, 0xFF00, 0xFF00, 1, 0xFFFF))),
        6: struct.pack(">HH", first, chance.choice(WORDS)),
        15: struct.pack(">HHB", first, count, size & 0xFF) + chance.randbytes(min(size, 246)),
        16: struct.pack(">H", first) + _words(chance, chance.choice(COUNTS)),
        17: b"",
        22: struct.pack(">HHH", first, chance.choice(WORDS), chance.choice(WORDS)),
        23: struct.pack(">HH", first, chance.choice(COUNTS[1:10]))
        + struct.pack(">H", chance.choice(ADDRESSES) & 0xFFFF)
        + _words(chance, chance.choice(COUNTS[1:12])),
        43: bytes([chance.choice((14, 14, 14, 14, 13)), chance.randrange(6), chance.randrange(7)]),
    }
    other = chance.randbytes(chance.randrange(8))
    return head + bodies.get(function, other)


def _words(chance: random.Random, count: int) -> bytes:
    size = min(count, 121)
    values = [chance.choice(WORDS) for _ in range(size)]
    stated = 2 * count if chance.random() < 0.97 else chance.randrange(256)
    return struct.pack(">HB", count, stated & 0xFF) + struct.pack(f">{size}H", *values)
