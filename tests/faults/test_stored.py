"""A setpoint that is kept over a loss of power, and what may be found in its place."""

import math
import struct

import pytest

from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.world import Site
from heatwright.spec import digest

SAVED_AFTER_S = 10.0
"""An operator who goes on pressing keys does not wear the EEPROM."""


def record(site: Site, setpoint_c: float) -> bytes:
    spec = int(digest(site.controller), 16)
    body = struct.pack("<IHBBfIf", spec, 1, 0, 0, 0.0, 0, setpoint_c)
    body = bytes([len(body) + 1]) + body
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return struct.pack("<H", crc) + body


@pytest.mark.parametrize(
    ("stored_c", "taken_c"),
    [
        (50.0, 50.0),
        (10.0, 10.0),
        (70.0, 70.0),
        (9.999, 20.0),
        (70.001, 20.0),
        (math.nan, 20.0),
        (math.inf, 20.0),
        (-math.inf, 20.0),
        (3e38, 20.0),
    ],
)
def test_only_a_setpoint_in_its_range_is_taken(
    pid_site: Site, stored_c: float, taken_c: float
) -> None:
    device = AvrDevice(pid_site.controller, pid_site.program)
    device.avr.eeprom.contents = record(pid_site, stored_c)
    device.sense("air", 30.0)
    device.advance(1.5)
    assert device.read("settings.air_setpoint_c") == taken_c
    assert device.read("fault.code") == 0


def test_it_survives_a_loss_of_power_once_saved(pid_site: Site) -> None:
    device = AvrDevice(pid_site.controller, pid_site.program)
    device.sense("air", 19.0)
    device.advance(1.0)
    for _ in range(3):
        device.press("up")
        device.advance(device.time_s + 0.1)
        device.press(None)
        device.advance(device.time_s + 0.1)
    assert device.avr.eeprom.writes == 0
    device.advance(device.time_s + SAVED_AFTER_S + 0.5)
    assert device.avr.eeprom.writes == len(record(pid_site, 50.0))
    device.power_cycle()
    device.sense("air", 19.0)
    device.advance(device.time_s + 1.5)
    assert device.read("settings.air_setpoint_c") == 50.0
