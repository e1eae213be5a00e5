"""Counters that wrap, and a period that does not drift."""

import numpy as np
import pytest
from eeprom_records import SLOTS, decoded, record, ring
from powered import PowerOn

from heatwright.sim.device import AvrDevice
from heatwright.spec import Controller

HOUR_S = 3600


def poke(device: AvrDevice, name: str, value: int) -> None:
    variable = device.variables[name]
    device.avr.write_ram(variable.address, value.to_bytes(variable.size, "little"))


def test_the_period_does_not_drift_in_an_hour(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(HOUR_S + 0.5)
    steps = device.steps("air")
    assert len(steps) == HOUR_S
    off_s = steps["time_s"] - steps["time_s"][0] - np.arange(HOUR_S)
    assert abs(off_s).max() < 0.001
    assert abs(steps["time_s"][0] - 1.0) < 0.02


def test_the_count_of_steps_wraps(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(3.5)
    poke(device, "loop_air.steps", 0xFFFD)
    device.advance(10.5)
    steps = device.steps("air")
    # The first of these is the change from outside.
    assert steps["steps"][3:].tolist() == [0xFFFD, 0xFFFE, 0xFFFF, 0, 1, 2, 3, 4]
    assert np.allclose(np.diff(steps["time_s"][4:]), 1.0, atol=0.001)
    assert device.read("fault.code") == 0


def test_the_clock_wraps(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(3.5)
    poke(device, "clock.c:seconds", 0xFFFFFFFE)
    device.advance(10.5)
    assert device.read("clock.c:seconds") == 5
    assert len(device.steps("air")) == 10
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(20.5)
    assert device.read("fault.code") == 1
    assert device.read("fault.time_s") < 20


@pytest.mark.parametrize("name", ["guard_air.heating_steps", "guard_air.frozen_steps"])
def test_a_count_near_its_end_trips_rather_than_wraps(power_on: PowerOn, name: str) -> None:
    device = power_on()
    device.advance(3.5)
    poke(device, name, 0xFFFF - 1)
    device.advance(6.5)
    assert device.read("fault.code") in {9, 10}


@pytest.mark.parametrize("last", [0, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF])
def test_sequence_numbers_wrap(power_on: PowerOn, chamber: Controller, last: int) -> None:
    """The newest of a full ring is found wherever the numbers are."""
    newest = 11
    image = ring(
        record(chamber, last - (newest - slot) % SLOTS, 6 if slot == newest else 1)
        for slot in range(SLOTS)
    )
    device = power_on(eeprom=image)
    device.advance(0.5)
    assert device.read("fault.code") == 6
    device.press("select")
    device.advance(1.0)
    device.press(None)
    device.advance(2.0)
    assert device.read("fault.code") == 0
    assert decoded(chamber, device.avr.eeprom.contents)[newest + 1] == ((last + 1) & 0xFFFF, 0)
    device.power_cycle()
    device.sense("air", 19.0)
    device.advance(2.5)
    assert device.read("fault.code") == 0
