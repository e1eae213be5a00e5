"""The ring of records in the EEPROM, as its description says it; written without the C."""

import re
import struct
from typing import NamedTuple

from heatwright.sim.host import HostBuild
from heatwright.spec import digest
from heatwright.spec.commands import tunable
from heatwright.spec.max31856 import selectable_of

BLANK = 0xFF
TYPES = "BEJKNRST"
"""Of thermocouples, by their codes."""


class Stored(NamedTuple):
    """What survives a loss of power."""

    code: int = 0
    temperature_c: float = 0.0
    time_s: int = 0
    setpoint_c: float = 0.0
    gains: tuple[float, ...] = ()


class Ring:
    def __init__(self, build: HostBuild) -> None:
        controller = build.controller
        ((name, self.loop),) = controller.loops.items()
        self.keeps_gains = tunable(controller, name)
        self.stores_setpoint = self.loop.setpoint.stored
        adjustable = self.loop.protection.maximum_adjustable
        sensor = controller.sensors[self.loop.sensor]
        self._others: list[float] = [self.loop.protection.maximum_c] * adjustable
        if selectable_of(sensor):
            self._others.append(TYPES.index(sensor.thermocouple))
        self._format = "<BIHBBfI" + "f" * (self.stores_setpoint + 3 * self.keeps_gains)
        self._format += "f" * adjustable + "B" * bool(selectable_of(sensor))
        self.size = 2 + struct.calcsize(self._format)
        self.stride = -(-self.size // 64) * 64
        self.bytes = controller.board.eeprom_bytes
        config = (build.project / "src" / "config.h").read_text(encoding="utf-8")
        self.slots = int(re.findall(r"SETTINGS_SLOTS (\d+)u", config)[0])
        assert 2 <= self.slots <= self.bytes // self.stride
        self.digest = int(digest(controller), 16)

    def record(self, sequence: int, stored: Stored, acknowledgements: int = 0) -> bytes:
        values = [self.size - 2, self.digest, sequence & 0xFFFF, stored.code, acknowledgements]
        values += [stored.temperature_c, stored.time_s]
        values += [stored.setpoint_c] * self.stores_setpoint
        values += stored.gains * self.keeps_gains
        values += self._others
        body = struct.pack(self._format, *values)
        return struct.pack("<H", self.crc(body)) + body

    def foreign(self, slot: int, size: int, digest: int) -> bytes:
        """A sound record of another specification, which has another digest."""
        other = struct.pack("<BI", size - 2, digest)
        body = other + bytes((slot + each) & 0xFF for each in range(size - 7))
        return struct.pack("<H", self.crc(body)) + body

    def crc(self, body: bytes) -> int:
        """CRC-16 as Modbus has it."""
        crc = 0xFFFF
        for byte in body:
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
        return crc

    def image(self, records: dict[int, bytes]) -> bytes:
        """An EEPROM with these records by their slots, and blank elsewhere."""
        image = bytearray([BLANK]) * self.bytes
        for slot, record in records.items():
            image[slot * self.stride : slot * self.stride + len(record)] = record
        return bytes(image)

    def is_valid(self, record: bytes) -> bool:
        return struct.pack("<H", self.crc(record[2:])) == record[:2]

    def at(self, image: bytes, slot: int) -> bytes:
        return image[slot * self.stride : slot * self.stride + self.size]
