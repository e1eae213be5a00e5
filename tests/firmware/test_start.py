"""From reset on: what the heater's pin does, what guards the program, what runs always."""

import numpy as np
import pytest
from powered import PowerOn

from heatwright.sim.native.pins import pin_number

WDTCSR, WDE, WDIE = 0x60, 0x08, 0x40
WDP_2S = 0x07
DRIVEN_WITHIN = 12
"""Cycles: the jump from the vector, then two single-bit instructions, and a few in between."""


def test_the_first_instructions_drive_the_heater_off(power_on: PowerOn) -> None:
    device = power_on()
    device.avr.run(0.05)
    events = device.avr.pins.take()
    heater = events[events["pin"] == pin_number("PD3")]
    assert heater["cycle"][0] <= DRIVEN_WITHIN
    assert heater["state"][0] == 0  # low, by the processor
    assert not (heater["state"] & 1).any()


@pytest.mark.parametrize("cause", ["external", "brown_out"])
def test_also_after_a_reset(power_on: PowerOn, cause: str) -> None:
    device = power_on()
    device.advance(3.5)
    assert device.outputs["heater"].on
    device.feed()
    device.avr.pins.take()
    reset_at = device.avr.cycle
    device.avr.reset(cause)
    device.avr.run(0.05)
    events = device.avr.pins.take()
    heater = events[events["pin"] == pin_number("PD3")]
    floating, driven = heater[:2]
    assert floating["cycle"] == reset_at
    assert floating["state"] & 1 == 0
    assert driven["state"] == 0
    assert driven["cycle"] - reset_at <= DRIVEN_WITHIN
    assert not (heater["state"] & 1).any()


def test_the_watchdog_is_armed(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(0.1)
    assert device.avr.read_ram(WDTCSR, 1)[0] & (WDE | WDIE | WDP_2S) == WDE | WDP_2S


def test_the_fan_runs_before_the_heater_and_always(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(20.0)
    assert device.read("fault.code") == 1
    events = device.avr.pins.take()
    fan = events[events["pin"] == pin_number("PB3")]
    heater = events[(events["pin"] == pin_number("PD3")) & (events["state"] & 1 == 1)]
    assert len(fan) == 0 or fan["state"][-1] & 1
    assert device.outputs["fan"].on
    on_cycles = device.avr.pins.high_cycles(pin_number("PB3"))
    assert on_cycles / device.avr.cycle > 0.999
    assert len(heater) == 0 or heater["cycle"][0] > device.avr.cycle - on_cycles


def test_no_heat_before_the_first_reading(power_on: PowerOn) -> None:
    device = power_on()
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(30.0)
    assert device.avr.pins.high_cycles(pin_number("PD3")) == 0
    assert device.read("fault.code") == 1
    assert device.shield.lcd.text == ("T=--.-°C VT=0   ", "E01 NO SENSOR   ")


def test_setpoint_at_start(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(0.1)
    assert device.read("settings.air_setpoint_c") == np.float32(20.0)
