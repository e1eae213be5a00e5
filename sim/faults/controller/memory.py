"""Damage of the controller: EEPROM, RAM, flash, clock, ADC and pins."""

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from importlib import import_module
from types import ModuleType
from typing import Any

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, answer_s, flash_s, start_up_s
from heatwright.sim.faults.fault import Fault, Trip, harmless, tripping
from heatwright.sim.faults.sensing.readings import SENSOR_RULES
from heatwright.sim.faults.site import LATCHED
from heatwright.sim.faults.world import STEP_S, Site, World
from heatwright.sim.native.pins import Level
from heatwright.spec import facts_of
from heatwright.spec.registry import module_of

SEED = 1
WATCH_S = 30.0
HIGHEST_BIT = 7
"""Highest bit of a byte; in the third byte of a float it is the lowest bit of the exponent."""
LOWEST_BIT = 0
SEAL, UNSEALED = "flash_seal", b"\xff\xff"
"""The constant with the program's checksum, and its value before seal.py has written it."""
BYTES = 7
"""How many bytes of a record are written before the power cut: half of the shortest record."""
REFERENCE_OFF = 0.6
WRONG_S = 1.0 + 2 * TICK_S
"""Longest time to a trip: the ADC is checked once a second; plus one tick before and after."""
HALF_PERCENT = 50.0
LOOKS = 3
HELD_S = (LOOKS + 2) * TICK_S
"""Longest time to a trip: LOOKS reads of a pin, the first at its switching, and two ticks."""
SLOW = 0.5
"""Factor of the clock frequency: for example a crystal of 8 MHz instead of 16 MHz."""
REST_S = 2.0
LONGEST_MS = 1000


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the controller's memory and of what its self-checks test."""
    start_s = start_up_s(site)
    yield tripping(site, "eeprom_damaged", damage, Trip(("settings_corrupt",), start_s))
    flipped = Trip(("memory_damaged",), site.loop.periods_s(2))
    yield tripping(site, "setpoint_flipped", flip_setpoint, flipped)
    if facts_of(site.controller).checked:
        yield from (replace(fault, floats=True) for fault in _self_checked(site, start_s))
    if site.controller.is_acknowledged:
        cut = harmless(site, "record_cut_short", cut_short, WATCH_S)
        yield replace(cut, make=lambda: latched(site), may=SENSOR_RULES, sensor_lies=True)


def _self_checked(site: Site, start_s: float) -> Iterator[Fault]:
    """Yield the faults that self-checks find; start_s -- time from a reset to the latched fault."""
    for name, cause, rule in (
        ("duty_left_out", leave_out_duty, "sequence_broken"),
        ("stack_guard_flipped", flip_stack_guard, "stack_overrun"),
        ("ram_cell_stuck", stick_cell, "ram_damaged"),
        ("eeprom_decays", flip_eeprom, "eeprom_worn"),
    ):
        at_once = tripping(site, name, cause, Trip((rule,), 2 * TICK_S))
        yield replace(at_once, off_within_s=2 * TICK_S, all_off=True)
    flash = Trip(("flash_damaged",), flash_s(site.program))
    yield tripping(site, "flash_flipped", flip_flash, flash, flip_flash)
    unsealed = Trip(("flash_unsealed",), start_s)
    yield tripping(site, "flash_not_sealed", unseal, unsealed, seal)
    if facts_of(site.controller).measures_known_voltage:
        off, right = partial(measure, times=REFERENCE_OFF), partial(measure, times=1.0)
        yield tripping(site, "adc_reference_off", off, Trip(("adc_wrong",), WRONG_S), right)
    yield _held_pin(site, start_s)
    if facts_of(site.controller).proves_watchdog:
        slow, usual = partial(change_crystal, times=SLOW), partial(change_crystal, times=1.0)
        wrong = Trip(("clock_wrong",), start_s / SLOW)
        yield tripping(site, "crystal_slow", slow, wrong, usual)


def damage(world: World) -> None:
    """Fill the EEPROM with random bytes while the power is off."""
    noise = random.Random(SEED)  # noqa: S311 - noise, not a secret
    world.device.avr.eeprom.contents = noise.randbytes(world.device.avr.eeprom.size)
    world.power_cut(STEP_S)


def flip(world: World, name: str, bit: int, *, byte: int = 0) -> None:
    """Flip a bit of a variable in the RAM; a negative byte counts from its end."""
    place = world.device.variables[name]
    world.device.avr.flip(place.address + byte % place.size, bit)


def flip_setpoint(world: World) -> None:
    """Flip a bit of the setpoint in the RAM: it doubles or halves."""
    flip(world, f"settings.{world.site.loop_name}_setpoint_c", HIGHEST_BIT, byte=-2)


def flip_flash(world: World) -> None:
    """Flip a bit of the last byte of flash: a variable's initial value, used only at a reset."""
    world.device.avr.flip_flash(len(world.site.program.flash) - 1, LOWEST_BIT)


def leave_out_duty(world: World) -> None:
    """Flip a bit of the marks of finished tasks: one seems to be finished before it begins."""
    flip(world, f"loop_{world.site.loop_name}.c:done", LOWEST_BIT)


def flip_stack_guard(world: World) -> None:
    """Flip a bit of the guard between stack and variables."""
    flip(world, "checks_stack_guard", LOWEST_BIT)


def flip_eeprom(world: World) -> None:
    """Flip a bit of every byte of the EEPROM."""
    eeprom = world.device.avr.eeprom
    eeprom.contents = bytes(byte ^ 1 << LOWEST_BIT for byte in eeprom.contents)


def stick_cell(world: World) -> None:
    """Hold a bit of a RAM cell at 0 while the next tick tests it."""
    avr, test = world.device.avr, world.site.program.function("ram_tick")
    variables = world.device.variables
    cell = variables["checks_stack_guard"].address
    avr.write_ram(variables["ram.c:place"].address, cell.to_bytes(2, "little"))

    def act(end_s: float) -> None:
        while avr.run_to_code(test, world.device.cycle_at(end_s)):
            avr.write_ram(cell, bytes([avr.read_ram(cell, 1)[0] & ~(1 << LOWEST_BIT)]))

    world.act_within(act)


def measure(world: World, times: float) -> None:
    """Let the ADC measure the chip's known voltage wrong by a factor."""
    part = world.device.avr.part
    world.device.avr.adc.known(part.adc_known, times * part.known_mv)


def change_crystal(world: World, times: float) -> None:
    """Restart with a crystal of another frequency: the spec's, times a factor."""
    world.device.crystal_hz = round(times * world.site.controller.board.clock_hz)
    world.power_cut(world.step_s)


def _held_pin(site: Site, start_s: float) -> Fault:
    """Return the fault that holds the relay's pin, otherwise the heater's, at its other level.

    A heater under PWM is read back only while it does not pulse: surely at a start.
    """
    output = site.controller.safety.relay or site.loop.heater
    switch = site.controller.switches[output]
    at_start = bool(switch.frequency_hz)
    within_s = HELD_S + (start_s if at_start else _asked_within_s(switch))
    holds = partial(hold_other, output=output, within_s=within_s, at_start=at_start)
    found = tripping(site, "pin_held", holds, Trip(("pin_held",), within_s))
    return replace(found, make=lambda: _followed(site))


def _followed(site: Site) -> World:
    """Return a world that heats, in which the relay has followed the heater."""
    world = starts.heating(site)
    world.run(world.step_s)
    return world


def _asked_within_s(output: Any) -> float:
    """Return the time in which an output commands one level in LOOKS ticks, not in a row, s."""
    if not output.is_windowed:
        return 0.0
    pulse_ticks = round(output.resolution_s / TICK_S) if output.distribution == "spread" else LOOKS
    return float(math.ceil(LOOKS / pulse_ticks) * output.window_s)


def hold_other(world: World, output: str, within_s: float, *, at_start: bool = False) -> None:
    """Short an output's pin to the level that it does not have now, until a fault is latched.

    An output with windows is held at the level that it has for the shorter part of a window: its
    pin is then wrong in at least LOOKS looks. at_start -- restart first: the output is then on.
    """
    if at_start:
        world.power_cut(world.step_s)
    avr, switch = world.device.avr, world.device.outputs[output]
    on = switch.on
    if world.site.controller.switches[output].is_windowed:
        on = world.loop("duty_percent") >= HALF_PERCENT
    held: Level = "low" if on == (switch.active == "high") else "high"
    latches, tripped = world.site.program.function("fault_trip"), False

    def act(end_s: float) -> None:
        nonlocal tripped
        tripped = avr.run_to_code(latches, world.device.cycle_at(end_s))
        if tripped:
            avr.pins.drive(switch.pin, None)
        world.device.advance(end_s)

    end_s = world.now_s + within_s
    avr.pins.drive(switch.pin, held)
    while not tripped and world.now_s < end_s:
        world.act_within(act)
    avr.pins.drive(switch.pin, None)


def unseal(world: World) -> None:
    """Restart with a program without its checksum."""
    _put_seal(world, UNSEALED)


def seal(world: World) -> None:
    """Restart with the program and its checksum again."""
    _put_seal(world, world.site.program.flash_bytes(SEAL, len(UNSEALED)))


def _put_seal(world: World, wanted: bytes) -> None:
    avr, place = world.device.avr, world.site.program.symbols[SEAL]
    for number, byte in enumerate(wanted):
        avr.put_flash(place + number, byte)
    avr.reset("external")


def latched(site: Site) -> World:
    """Return a world with a fault that is latched and stored, and whose cause is removed."""
    world = starts.heating(site)
    cut_line(world)
    world.until(LATCHED, answer_s(site.loop))
    world.run(REST_S)
    mend_line(world)
    return world


def cut_line(world: World) -> None:
    """Disconnect the loop's sensor, in a way that suits its kind."""
    module_of_sensor(world.site, world.site.loop.sensor).cut(world)


def mend_line(world: World) -> None:
    """Undo `cut_line`."""
    module_of_sensor(world.site, world.site.loop.sensor).mend(world)


def module_of_sensor(site: Site, sensor: str) -> ModuleType:
    """Return the module with the faults of a sensor, which its kind determines."""
    return import_module(module_of("sensor", "faults", site.controller.sensors[sensor].kind))


def cut_short(world: World) -> None:
    """Acknowledge, and cut the power while the acknowledgement is written to the EEPROM."""
    eeprom = world.device.avr.eeprom
    before = eeprom.writes
    world.hand.begin_acknowledging(world)
    for _ in range(LONGEST_MS):
        world.device.advance(world.now_s + 0.001)
        if eeprom.writes >= before + BYTES and eeprom.writing:
            break
    world.power_cut(STEP_S, undefined=random.Random(SEED).randrange(256))  # noqa: S311 - noise
