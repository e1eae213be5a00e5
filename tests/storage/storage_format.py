"""What stands in the EEPROM, as docs/storage.md says it; written without the C."""

import struct
from functools import lru_cache
from typing import NamedTuple

from heatwright.sim.interfaces.modbus_rtu.frames import crc
from heatwright.spec import Controller, digest, facts_of
from heatwright.spec.board.eeprom import layout

BLANK = 0xFF
SETTINGS_STRIDE = 64
NAME_BYTES = 13
OVER, RATE, FAST, HOLD, UNTIL = 1, 2, 3, 4, 5
TYPES = "BEJKNRST"


@lru_cache(10_000)
def crc16(data: bytes) -> int:
    return int.from_bytes(crc(data), "little")


class Segment(NamedTuple):
    kind: int
    to_dc: int = 0
    amount: int = 0


class Stored(NamedTuple):
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


class Settings(NamedTuple):
    """A record of settings; of gains, limits, a maximum, a type, numbers those that it keeps."""

    code: int
    temperature_c: float
    time_s: int
    setpoint_c: float
    gains: tuple[float, ...]
    maximum_c: float | None = None
    type: int | None = None
    limits: tuple[float, ...] = ()  # least and most of the integral, most of the output, %
    numbers: tuple[float, ...] = ()


class Memory:
    def __init__(self, controller: Controller) -> None:
        ((name, loop),) = controller.loops.items()
        areas, programs = layout(controller), controller.programs
        self.bytes = controller.board.eeprom_bytes
        self.digest = struct.pack("<I", int(digest(controller), 16))
        self.settings_slots = areas.settings.slots
        self.initial_c = loop.setpoint.initial_c
        self.has_setpoint, self.has_gains = loop.setpoint.stored, facts_of(controller, name).tunable
        self.has_limits = controller.loops[name].algorithm.limits_adjustable
        self.has_maximum = loop.protection.maximum_adjustable
        self.has_type = bool(getattr(controller.sensors[loop.sensor], "selectable", ()))
        self.numbers = facts_of(controller, name).keyed_numbers
        self._counts_trips = controller.lockout is not None
        self._settings = struct.Struct(
            f"<B4sHBB{'B' * self._counts_trips}fI"
            + "f" * (self.has_setpoint + 3 * self.has_gains + 3 * self.has_limits)
            + "f" * (self.has_maximum + len(self.numbers)) + "B" * self.has_type
        )  # fmt: skip
        self.settings_bytes = 2 + self._settings.size
        self.programs_at = areas.programs.start
        self.progress_at, self.progress_slots = areas.progress.start, areas.progress.slots
        if programs:
            self.points, self.places = programs.points, programs.places
            self.program_bytes = 1 + NAME_BYTES + 1 + 7 * programs.points + 2 + 1
            self._given = [_given(each) for each in programs.stored]

    def settings_slot(
        self, sequence: int, kept: Settings, digest: bytes | None = None, seen: int = 0
    ) -> bytes:
        head = (self.settings_bytes - 2, digest or self.digest, sequence & 0xFFFF)
        values = [kept.setpoint_c] * self.has_setpoint + [*kept.gains, *kept.limits]
        values += [kept.maximum_c or 0.0] * self.has_maximum + [*kept.numbers]
        values += [kept.type or 0] * self.has_type
        fault = (kept.code, seen, *[0] * self._counts_trips, *kept[1:3])
        body = self._settings.pack(*head, *fault, *values)
        return struct.pack("<H", crc16(body)) + body

    def settings_in(self, image: bytes, slot: int) -> tuple[int, Settings] | None:
        raw = image[slot * SETTINGS_STRIDE :][: self.settings_bytes]
        head = struct.pack("<HB", crc16(raw[2:]), self.settings_bytes - 2) + self.digest
        if raw[:7] != head:
            return None
        _, _, sequence, code, _, *kept = self._settings.unpack(raw[2:])
        temperature_c, time_s = kept[self._counts_trips : self._counts_trips + 2]
        del kept[: self._counts_trips + 2]
        setpoint_c = kept.pop(0) if self.has_setpoint else self.initial_c
        gains = tuple(kept.pop(0) for _ in range(3 * self.has_gains))
        limits = tuple(kept.pop(0) for _ in range(3 * self.has_limits))
        maximum_c = kept.pop(0) if self.has_maximum else None
        numbers = tuple(kept.pop(0) for _ in self.numbers)
        own_type = kept.pop() if self.has_type else None
        others = setpoint_c, gains, maximum_c, own_type, limits, numbers
        return sequence, Settings(code, temperature_c, time_s, *others)

    def settings(self, image: bytes) -> Settings | None:
        """The newest valid record; numbers are near each other, but wrap."""
        newest: tuple[int, Settings] | None = None
        for slot in range(self.settings_slots):
            found = self.settings_in(image, slot)
            if found and (newest is None or 0 < (found[0] - newest[0]) % 65536 < 32768):
                newest = found
        return newest and newest[1]

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

    def given(self, number: int) -> Stored | None:
        return self._given[number - 1] if 0 < number <= len(self._given) else None

    def program(self, image: bytes, number: int) -> Stored | None:
        """The newer valid one of a place, else the spec's; None where there is none."""
        found = [self._program_in(image, number, slot) for slot in (0, 1)]
        valid = [each for each in found if each is not None]
        if not valid:
            return self.given(number)
        (first, one), (second, other) = valid[0], valid[-1]
        newest = other if 0 < (second - first) % 256 < 128 else one
        return newest if newest.segments else None

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
        valid = [each for each in found if each is not None]
        return max(valid, key=lambda each: each[0], default=None)

    def image(self, *pieces: tuple[int, bytes]) -> bytes:
        """An EEPROM with these pieces at their places, and blank elsewhere."""
        return self.with_at(bytes([BLANK]) * self.bytes, *pieces)

    @staticmethod
    def with_at(image: bytes, *pieces: tuple[int, bytes]) -> bytes:
        changed = bytearray(image)
        for at, piece in pieces:
            changed[at : at + len(piece)] = piece
        return bytes(changed)

    @property
    def blank(self) -> bytes:
        return self.image()


def _given(program: object) -> Stored:
    kinds = {"over": OVER, "rate": RATE, "fast": FAST, "hold": HOLD, "until": UNTIL}
    segments = []
    for each in program.segments:  # type: ignore[attr-defined]
        amount = each.over_s or each.hold_s or 10 * (each.at_k_per_h or 0)
        segments.append(Segment(kinds[each.kind], round(10 * (each.to_c or 0)), round(amount)))
    return Stored(program.name.encode(), tuple(segments))  # type: ignore[attr-defined]
