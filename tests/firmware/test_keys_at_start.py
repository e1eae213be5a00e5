"""A key that is down when the power comes on was not pressed by anyone who read the display."""

import pytest
from powered import PowerOn

DDRC, PORTC = 0x27, 0x28
"""ATmega328P data sheet, register summary; A0 is bit 0."""


def latched(power_on: PowerOn) -> bytes:
    """An EEPROM that holds an unacknowledged fault."""
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(12.0)
    assert device.read("fault.code") == 1
    contents: bytes = device.avr.eeprom.contents
    return contents


def test_select_held_from_the_start_acknowledges_nothing(power_on: PowerOn) -> None:
    device = power_on(eeprom=latched(power_on))
    device.press("select")
    device.advance(5.0)
    assert device.read("fault.code") == 1
    device.press(None)
    device.advance(5.2)
    device.press("select")
    device.advance(5.4)
    assert device.read("fault.code") == 0


@pytest.mark.parametrize("key", ["up", "down"])
def test_the_setpoint_stands_while_a_fault_hides_it(power_on: PowerOn, key: str) -> None:
    device = power_on(eeprom=latched(power_on))
    device.advance(1.0)
    device.press(key)
    device.advance(1.2)
    device.press(None)
    device.advance(1.4)
    assert device.read("settings.air_setpoint_c") == 20
    assert device.read("fault.code") == 1


def test_the_keys_pin_does_not_float_without_the_shield(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(0.5)
    assert device.avr.read_ram(DDRC, 1)[0] & 1 == 0
    assert device.avr.read_ram(PORTC, 1)[0] & 1 == 1, "the pull-up of A0"
