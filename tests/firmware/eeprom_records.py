"""Records as the firmware stores them, written a second time, from its description alone."""

import struct

from heatwright.spec import Controller, digest

SIZE = 14
SLOTS = 64


def crc16(data: bytes, start: int) -> int:
    """Modbus's CRC, from another start."""
    crc = start
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def record(
    controller: Controller, sequence: int, code: int, temperature_c: float = 0.0, time_s: int = 0
) -> bytes:
    """A record without settings: what the chamber keeps."""
    body = struct.pack("<HBBfI", sequence & 0xFFFF, code, 0, temperature_c, time_s)
    start = int(digest(controller), 16) & 0xFFFF
    return body + struct.pack("<H", crc16(body, start))


def decoded(controller: Controller, image: bytes) -> dict[int, tuple[int, int]]:
    """The valid records: slot to sequence and code."""
    found = {}
    for slot in range(SLOTS):
        raw = image[slot * SIZE : (slot + 1) * SIZE]
        sequence, code, *_ = struct.unpack("<HBBfI", raw[:-2])
        start = int(digest(controller), 16) & 0xFFFF
        if raw[-2:] == struct.pack("<H", crc16(raw[:-2], start)):
            found[slot] = (sequence, code)
    return found
