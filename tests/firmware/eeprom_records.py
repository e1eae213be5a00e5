"""Records as the firmware stores them, written a second time, from its description alone."""

import struct
from collections.abc import Iterable

from heatwright.spec import Controller, digest

SIZE = 19
STRIDE = 64
SLOTS = 16


def crc16(data: bytes) -> int:
    """Modbus's CRC."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def record(
    controller: Controller, sequence: int, code: int, temperature_c: float = 0.0, time_s: int = 0
) -> bytes:
    """A record without settings: what the chamber keeps."""
    own = int(digest(controller), 16)
    body = struct.pack("<BIHBBfI", SIZE - 2, own, sequence & 0xFFFF, code, 0, temperature_c, time_s)
    return struct.pack("<H", crc16(body)) + body


def ring(records: Iterable[bytes]) -> bytes:
    """An EEPROM with these records in its first slots."""
    return b"".join(each.ljust(STRIDE, b"\xff") for each in records)


def decoded(controller: Controller, image: bytes) -> dict[int, tuple[int, int]]:
    """The valid records: slot to sequence and code."""
    found = {}
    for slot in range(SLOTS):
        raw = image[slot * STRIDE : slot * STRIDE + SIZE]
        _, own, sequence, code, *_ = struct.unpack("<BIHBBfI", raw[2:])
        ours = own == int(digest(controller), 16)
        if ours and raw[:2] == struct.pack("<H", crc16(raw[2:])):
            found[slot] = (sequence, code)
    return found
