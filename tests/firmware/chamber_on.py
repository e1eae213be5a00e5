"""The chamber's controller just powered on; its records, written a second time."""

import struct
from collections.abc import Iterable

from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.native.pins import pin_number
from heatwright.spec import digest

CHAMBER = example("chamber").controller
ROOM_C = 19.0
SETPOINT = "settings.air_setpoint_c"
HEATER, FAN = pin_number("PD3"), pin_number("PB3")
RECORD_BYTES, STRIDE, SLOTS = 19, 64, 16


def program() -> Elf:
    """Return the firmware; an arena puts a broken one in its place."""
    return whole("chamber")


def power_on(
    eeprom: bytes = b"", temperature_c: float = ROOM_C, elf: Elf | None = None
) -> AvrDevice:
    """Return the chamber's controller at time 0, its sensor at a temperature."""
    device = AvrDevice(CHAMBER, elf or program())
    device.avr.eeprom.contents = eeprom
    device.sense("air", temperature_c)
    return device


def latched() -> AvrDevice:
    """Power on with an EEPROM that holds an unacknowledged fault."""
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(12.0)
    assert device.read("fault.code") == 1
    return power_on(device.avr.eeprom.contents)


def press(device: AvrDevice, key: str, for_s: float = 0.1) -> None:
    """Press a key and let it go."""
    device.press(key)
    device.advance(device.time_s + for_s)
    device.press(None)
    device.advance(device.time_s + 0.1)


def put(device: AvrDevice, name: str, value: int) -> None:
    """Set a variable of the firmware."""
    variable = device.variables[name]
    device.avr.write_ram(variable.address, value.to_bytes(variable.size, "little"))


def crc16(data: bytes) -> int:
    """Modbus's CRC."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def record(sequence: int, code: int, temperature_c: float = 0.0, time_s: int = 0) -> bytes:
    """Return a record without settings: what the chamber keeps, by the description alone."""
    values = (int(digest(CHAMBER), 16), sequence & 0xFFFF, code, 0, temperature_c, time_s)
    body = struct.pack("<BIHBBfI", RECORD_BYTES - 2, *values)
    return struct.pack("<H", crc16(body)) + body


def ring(records: Iterable[bytes]) -> bytes:
    """Return an EEPROM with these records in its first slots."""
    return b"".join(each.ljust(STRIDE, b"\xff") for each in records)


def decoded(image: bytes) -> dict[int, tuple[int, int]]:
    """Return the valid records: slot to sequence and code."""
    found = {}
    for slot in range(SLOTS):
        raw = image[slot * STRIDE : slot * STRIDE + RECORD_BYTES]
        _, own, sequence, code, *_ = struct.unpack("<BIHBBfI", raw[2:])
        if own == int(digest(CHAMBER), 16) and raw[:2] == struct.pack("<H", crc16(raw[2:])):
            found[slot] = (sequence, code)
    return found
