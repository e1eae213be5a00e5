"""From reset on: what the heater's pin does, what guards the program, what runs always."""

from pathlib import Path

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, began_s, example, whole
from rig.outputs import Recorded

from heatwright.sim.bench import ReferenceDevice
from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.native.pins import pin_number

CHAMBER = example("chamber").controller
ROOM_C = 19.0
SETPOINT = "settings.air_setpoint_c"
HEATER, FAN = pin_number("PD3"), pin_number("PB3")
WDTCSR, WDE, WDIE = 0x60, 0x08, 0x40
WDP_2S = 0x07
DDRC, PORTC = 0x27, 0x28  # ATmega328P data sheet, register summary; A0 is bit 0
DRIVEN_WITHIN = 12
"""Cycles: the jump from the vector, then two single-bit instructions, and a few in between."""
HANG_MARK, MARKED = 0x5AC3, "reset_hang_mark"
RISE_RATE, WATCHDOG_RESET = 8, 14


def program() -> Elf:
    """Return the firmware; an arena puts a broken one in its place."""
    return whole("chamber")


def power_on(eeprom: bytes = b"", felt_c: float = ROOM_C, elf: Elf | None = None) -> AvrDevice:
    device = AvrDevice(CHAMBER, elf or program())
    device.log_edges(["heater"])
    device.avr.eeprom.contents = eeprom
    device.sense("air", felt_c)
    return device


def latched() -> AvrDevice:
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(12.0)
    assert device.read("fault.code") == 1
    return power_on(device.avr.eeprom.contents)


def press(device: AvrDevice, key: str, for_s: float = 0.1) -> None:
    device.press(key)
    device.advance(device.time_s + for_s)
    device.press(None)
    device.advance(device.time_s + 0.1)


def put(device: AvrDevice, name: str, value: int) -> None:
    variable = device.variables[name]
    device.avr.write_ram(variable.address, value.to_bytes(variable.size, "little"))


@pytest.mark.parametrize("cause", [None, "external", "brown_out"])
def test_the_first_instructions_drive_the_heater_off(chamber_elf: Path, cause: str | None) -> None:
    """On the binary that PlatformIO makes; at power-up, and after a reset while it heats."""
    device = power_on(elf=Elf(chamber_elf))
    if cause:
        device.advance(3.5)
        assert device.outputs["heater"].on
        device.feed()
        device.avr.pins.take()
        device.avr.reset(cause)
    reset_at = device.avr.cycle
    device.avr.run(0.05)
    events = device.avr.pins.take()
    heater = events[events["pin"] == HEATER]
    if cause:
        floating, heater = heater[0], heater[1:]
        assert (floating["cycle"], floating["state"] & 1) == (reset_at, 0)
    assert heater["cycle"][0] - reset_at <= DRIVEN_WITHIN
    assert heater["state"][0] == 0  # low, by the processor
    assert not (heater["state"] & 1).any()


def test_the_watchdog_is_armed_no_pin_floats_and_the_setpoint_is_the_first() -> None:
    device = power_on()
    device.advance(0.5)
    assert device.avr.read_ram(WDTCSR, 1)[0] & (WDE | WDIE | WDP_2S) == WDE | WDP_2S
    assert device.avr.read_ram(DDRC, 1)[0] & 1 == 0
    assert device.avr.read_ram(PORTC, 1)[0] & 1 == 1, "the pull-up of A0, without the shield, too"
    assert device.read(SETPOINT) == np.float32(20.0)


def test_the_fan_runs_before_the_heater_and_always() -> None:
    device = power_on()
    recorded = Recorded(device, "heater")
    device.advance(3.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(20.0)
    assert device.read("fault.code") == 1
    device.feed()
    assert device.outputs["fan"].on
    on_cycles = device.avr.pins.high_cycles(FAN)
    assert device.avr.cycle - on_cycles < (device.steps("air")["time_s"][0] - 1.0) * CLOCK_HZ
    assert recorded.cycles("heater")[0] > device.avr.cycle - on_cycles


def test_no_heat_before_the_first_reading() -> None:
    device = power_on()
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(30.0)
    assert device.avr.pins.high_cycles(HEATER) == 0
    assert device.read("fault.code") == 1
    assert device.shield.lcd.text == ("T=--.-°C VT=0   ", "E01 NO SENSOR   ")


# -- a key that is down when the power comes on was not pressed by anyone who read the display


def test_select_held_from_the_start_acknowledges_nothing() -> None:
    """The fault that was kept is shown as it was, and nothing heats meanwhile."""
    device = latched()
    device.press("select")
    device.advance(5.0)
    assert device.read("fault.code") == 1
    assert device.read("fault.temperature_c") == np.float32(ROOM_C)
    assert 2 < device.read("fault.time_s") < 12
    assert device.shield.lcd.text[1] == "E01 NO SENSOR   "
    assert device.avr.pins.high_cycles(HEATER) == 0
    device.press(None)
    device.advance(6.2)
    press(device, "select")
    assert device.read("fault.code") == 0


@pytest.mark.parametrize(
    ("moves", "meant"),
    [
        ("select 0.10", True), ("select 1.95", True), ("select 0.06", False), ("select 2.1", False),
        ("up 0.1  - 1.1  select 0.1", True), ("up 0.1  - 0.9  select 0.1", False),
        ("select 0.06  - 0.02  select 0.1", False), ("up 0.1  select 0.1", False),
        ("select 0.06  - 0.9  select 0.1", False), ("select 0.06  - 1.1  select 0.1", True),
        ("select 0.3  - 0.3  " * 20, True), ("select 0.05  - 0.3  " * 20, False),
    ],
)  # fmt: skip
def test_select_acknowledges_when_it_is_let_go_and_was_meant(moves: str, meant: bool) -> None:
    """Neither if it hangs nor if it flickers: nothing was down for 1 s, then it for 0.08 s to 2 s.

    The model, which has no samples, agrees.
    """
    device, model = latched(), ReferenceDevice(CHAMBER)
    for felt_c, until_s in ((300.0, 2.5), (ROOM_C, 5.0)):
        model.sense("air", felt_c)
        model.advance(until_s)
    device.advance(5.0)
    assert device.read("fault.code")
    assert model.fault
    now_s, words = 5.0, [*moves.split(), "-", "0.1"]
    for key, for_s in zip(words[::2], words[1::2], strict=True):
        now_s += float(for_s)
        for each in (device, model):
            each.press(None if key == "-" else key)
            each.advance(now_s)
    assert (device.read("fault.code") == 0, model.fault == 0) == (meant, meant)


@pytest.mark.parametrize(("down_s", "left"), [(5.6, RISE_RATE), (8.0, 0)])
def test_select_acknowledges_no_fault_that_came_while_it_was_down(down_s: float, left: int) -> None:
    """The reading jumps at 5.5 s; the model agrees."""
    device, model = power_on(), ReferenceDevice(CHAMBER)
    for each in (device, model):
        for felt_c, until_s in ((ROOM_C, 5.5), (ROOM_C + 50.0, down_s)):
            each.sense("air", felt_c)
            each.advance(until_s)
        each.press("select")
        each.advance(down_s + 1.9)
    assert (device.read("fault.code"), model.fault) == (RISE_RATE, RISE_RATE)
    for each in (device, model):
        each.press(None)
        each.advance(down_s + 2.0)
    assert (device.read("fault.code"), model.fault) == (left, left)


@pytest.mark.parametrize("key", ["up", "down"])
def test_the_setpoint_stands_while_a_fault_hides_it(key: str) -> None:
    device = latched()
    device.advance(1.0)
    press(device, key)
    device.advance(1.4)
    assert (device.read(SETPOINT), device.read("fault.code")) == (20, 1)


# -- a hang is told even where a boot loader clears MCUSR before the program starts


@pytest.mark.parametrize(
    ("reset", "marked", "found"),
    [("external", True, WATCHDOG_RESET), ("external", False, 0), (None, True, 0)],
)
def test_a_reset_with_the_mark_was_a_hang(reset: str | None, marked: bool, found: int) -> None:
    """RAM is as it was, and there is no watchdog flag; at power-up the mark means nothing."""
    device = power_on()
    if reset:
        device.advance(3.5)
        assert device.read(MARKED) == 0
    if marked:
        put(device, MARKED, HANG_MARK)
    if reset:
        device.avr.reset(reset)
    device.avr.run(began_s("chamber") + 0.05)
    assert (device.read("fault.code"), device.read(MARKED)) == (found, 0)


def test_the_gate_sets_the_mark_when_the_main_loop_stands() -> None:
    device = power_on()
    device.advance(3.5)
    device.avr.run(0.0051)  # between two ticks
    # The gate counts this permit down; a loop that stands no longer renews it.
    put(device, "gate.c:main_ticks", 1)
    seen = []
    for _ in range(3000):
        device.avr.run(4e-6)
        seen.append(int(device.read(MARKED)))
    assert HANG_MARK in seen
    assert seen[-1] == 0, "a loop that goes on takes it back"


# -- counters that wrap


def test_the_counts_of_steps_and_seconds_wrap() -> None:
    device = power_on()
    device.advance(3.5)
    put(device, "loop_air.steps", 0xFFFD)
    put(device, "clock.c:seconds", 0xFFFFFFFE)
    device.advance(10.5)
    steps = device.steps("air")
    # The first of these is the change from outside.
    assert steps["steps"][3:].tolist() == [0xFFFD, 0xFFFE, 0xFFFF, 0, 1, 2, 3, 4]
    assert np.allclose(np.diff(steps["time_s"][4:]), 1.0, atol=0.001)
    assert (device.read("clock.c:seconds"), device.read("fault.code")) == (5, 0)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(20.5)
    assert device.read("fault.code") == 1
    assert device.read("fault.time_s") < 20


@pytest.mark.parametrize("name", ["heating_steps", "frozen_steps"])
def test_a_count_near_its_end_trips_rather_than_wraps(name: str) -> None:
    device = power_on()
    device.advance(3.5)
    put(device, f"guard_air.{name}", 0xFFFF - 1)
    device.advance(6.5)
    assert device.read("fault.code") in {9, 10}
