"""What stands in the EEPROM, as docs/storage.md says it; written without the C."""

import struct
from typing import NamedTuple

from heatwright.spec import Controller, digest

BLANK = 0xFF
NAME_BYTES = 13
OVER, RATE, FAST, HOLD, UNTIL = 1, 2, 3, 4, 5


def _shifted(value: int) -> int:
    for _ in range(8):
        value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


_SHIFTED = [_shifted(byte) for byte in range(256)]


def crc16(data: bytes) -> int:
    """Modbus's CRC."""
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ _SHIFTED[(crc ^ byte) & 0xFF]
    return crc


class Segment(NamedTuple):
    kind: int
    to_dc: int = 0
    amount: int = 0


class Stored(NamedTuple):
    """A program as it is kept."""

    name: bytes
    segments: tuple[Segment, ...]

    def packed(self, points: int) -> bytes:
        body = struct.pack("<13sB", self.name, len(self.segments))
        body += b"".join(struct.pack("<BhI", *each) for each in self.segments)
        return body.ljust(NAME_BYTES + 1 + 7 * points, b"\0")

    @property
    def crc(self) -> int:
        return crc16(self.packed(len(self.segments)))

    @classmethod
    def of(cls, raw: bytes) -> "Stored":
        name, count = struct.unpack_from("<13sB", raw)
        at = NAME_BYTES + 1
        segments = [Segment(*struct.unpack_from("<BhI", raw, at + 7 * i)) for i in range(count)]
        return cls(name.rstrip(b"\0"), tuple(segments))


class Progress(NamedTuple):
    """A record of where the program is."""

    state: int
    number: int
    segment: int
    ended: int
    program_crc: int
    first_c: float
    from_c: float
    setpoint_c: float
    temperature_c: float
    elapsed: int
    clock: int
    segment_clock: int
    energy: int


_PROGRESS = struct.Struct("<BBBBHffffIIII")
PROGRESS_BYTES = 4 + _PROGRESS.size + 2 + 1


class Memory:
    """The EEPROM of a controller."""

    def __init__(self, controller: Controller) -> None:
        programs = controller.programs
        assert programs is not None
        self.bytes = controller.board.eeprom_bytes
        self.digest = struct.pack("<I", int(digest(controller), 16))
        self.points, self.places = programs.points, programs.places
        self.program_bytes = 1 + NAME_BYTES + 1 + 7 * programs.points + 2 + 1
        self.programs_at = self.progress_at = self.progress_slots = 0

    def lay_out(self, programs_at: int, progress_at: int, progress_slots: int) -> None:
        """Take what config.h says of the places."""
        self.programs_at = programs_at
        self.progress_at, self.progress_slots = progress_at, progress_slots

    # ---- programs ----

    def program_at(self, number: int, slot: int) -> int:
        return self.programs_at + (2 * (number - 1) + slot) * self.program_bytes

    def program_slot(self, turn: int, stored: Stored, digest: bytes | None = None) -> bytes:
        body = bytes([turn & 0xFF]) + stored.packed(self.points)
        crc = crc16((digest or self.digest) + body)
        return body + struct.pack("<HB", crc, turn & 0xFF)

    def _program_in(self, image: bytes, number: int, slot: int) -> tuple[int, Stored] | None:
        at = self.program_at(number, slot)
        raw = image[at : at + self.program_bytes]
        crc, last = struct.unpack("<HB", raw[-3:])
        if last != raw[0] or crc != crc16(self.digest + raw[:-3]):
            return None
        return raw[0], Stored.of(raw[1:-3])

    def program(self, image: bytes, number: int) -> Stored | None:
        """The newer valid one of a place, None where there is none."""
        found = [self._program_in(image, number, slot) for slot in (0, 1)]
        valid = [each for each in found if each is not None]
        if len(valid) < 2:
            return valid[0][1] if valid else None
        (first, one), (second, other) = valid
        return other if 0 < (second - first) % 256 < 128 else one

    # ---- progress ----

    def progress_slot(self, sequence: int, record: Progress, digest: bytes | None = None) -> bytes:
        body = struct.pack("<I", sequence) + _PROGRESS.pack(*record)
        crc = crc16((digest or self.digest) + body)
        return body + struct.pack("<HB", crc, sequence & 0xFF)

    def progress_in(self, image: bytes, slot: int) -> tuple[int, Progress] | None:
        at = self.progress_at + slot * PROGRESS_BYTES
        raw = image[at : at + PROGRESS_BYTES]
        (sequence,) = struct.unpack_from("<I", raw)
        crc, last = struct.unpack("<HB", raw[-3:])
        if last != sequence & 0xFF or crc != crc16(self.digest + raw[:-3]):
            return None
        return sequence, Progress(*_PROGRESS.unpack(raw[4:-3]))

    def progress(self, image: bytes) -> tuple[int, Progress] | None:
        """The newest valid record and its sequence number."""
        found = [self.progress_in(image, slot) for slot in range(self.progress_slots)]
        return max((each for each in found if each is not None), default=None)

    def with_at(self, image: bytes, *pieces: tuple[int, bytes]) -> bytes:
        changed = bytearray(image)
        for at, piece in pieces:
            changed[at : at + len(piece)] = piece
        return bytes(changed)

    @property
    def blank(self) -> bytes:
        return bytes([BLANK]) * self.bytes
