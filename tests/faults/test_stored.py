"""A setpoint that is kept over a loss of power, and what may be found in its place."""

import math
import struct

import pytest
from fault_machines import site_of

from heatwright.sim.device import AvrDevice
from heatwright.spec import digest

RECORD_BYTES = 23
SAVED_AFTER_S = 10.0
"""An operator who goes on pressing keys does not wear the EEPROM."""


def device_of() -> AvrDevice:
    return AvrDevice(site_of("pid").controller, site_of("pid").program)


def record(setpoint_c: float) -> bytes:
    spec = int(digest(site_of("pid").controller), 16)
    body = struct.pack("<BIHBBfIf", RECORD_BYTES - 2, spec, 1, 0, 0, 0.0, 0, setpoint_c)
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return struct.pack("<H", crc) + body


@pytest.mark.parametrize(
    ("stored_c", "taken_c"),
    [(inside, inside) for inside in (10.0, 50.0, 70.0)]
    + [(beyond, 20.0) for beyond in (9.999, 70.001, math.nan, math.inf, -math.inf, 3e38)],
)
def test_only_a_setpoint_in_its_range_is_taken(stored_c: float, taken_c: float) -> None:
    device = device_of()
    device.avr.eeprom.contents = record(stored_c)
    device.sense("air", 30.0)
    device.advance(1.5)
    assert device.read("settings.air_setpoint_c") == taken_c
    assert device.read("fault.code") == 0


def test_it_survives_a_loss_of_power_once_saved() -> None:
    device = device_of()
    device.sense("air", 19.0)
    device.advance(1.0)
    for _ in range(3):
        device.press("up")
        device.advance(device.time_s + 0.1)
        device.press(None)
        device.advance(device.time_s + 0.1)
    assert device.avr.eeprom.writes == 0
    device.advance(device.time_s + SAVED_AFTER_S + 0.5)
    assert device.avr.eeprom.writes == RECORD_BYTES
    device.power_cycle()
    device.sense("air", 19.0)
    device.advance(device.time_s + 1.5)
    assert device.read("settings.air_setpoint_c") == 50.0
