"""The firmware's reader on several boards and crystals, and what it makes of any answer."""

import random

import numpy as np
import pytest
from converter_specs import KINDS, PINS, program, spec_of

from heatwright.generator import plan_firmware, render
from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import replay
from heatwright.sim.sensors.spi_chip import SpiChip

PERIOD_S = 0.3
AFTER_S = 0.02
"""We look so long after a step is due."""
SPEED = [("uno", ""), ("leonardo", ""), ("mega2560", ""), ("atmega1284p", ""),
         ("atmega1284p", ", clock: 20 MHz"), ("atmega1284p", ", clock: 8 MHz")]  # fmt: skip
MOST_US = 100.0
MOST_MASKED_US = 20.0
VALID, NO_ANSWER, SHORT, CRC, STALE, OPEN = 0, 1, 2, 3, 4, 17

on_boards = pytest.mark.parametrize(("board", "clock"), SPEED)
of_both = pytest.mark.parametrize("kind", KINDS)


def crucible(kind: str, board: str = "uno", *, clock: str = "") -> tuple[AvrDevice, SpiChip]:
    device = AvrDevice(
        spec_of(kind, board, clock=clock).controller, program(kind, board, clock=clock)
    )
    chip = device.sensors["tip"]
    assert isinstance(chip, SpiChip)
    device.advance(AFTER_S)
    return device, chip


def next_steps(device: AvrDevice, count: int = 1) -> np.ndarray:
    """Run so many periods, and return their steps."""
    done = len(device.steps("crucible"))
    device.advance(device.time_s + count * PERIOD_S)
    return device.steps("crucible")[done:]


@of_both
@on_boards
def test_it_keeps_to_the_data_sheet_and_reads_in_time(kind: str, board: str, clock: str) -> None:
    device, chip = crucible(kind, board, clock=clock)
    profile = device.avr.profile(device.elf)
    device.advance(10 * PERIOD_S + AFTER_S)
    steps = device.steps("crucible")
    assert steps["reading_status"].tolist() == [VALID] * 10
    assert chip.reads == 10
    assert chip.port.violations == 0
    assert {"setup", "high", "low", "period", "read", "hold", "idle"} == set(chip.port.phases)
    us = 1e6 / device.avr.clock_hz
    assert profile.functions["sensor_tip_tick"].longest * us < MOST_US
    assert profile.functions["spi_tip_read"].masked * us < MOST_MASKED_US


@of_both
@pytest.mark.parametrize("board", PINS)
def test_temperatures_over_its_range(kind: str, board: str) -> None:
    """The nearest code, after every change in time for the next step but one."""
    device, _ = crucible(kind, board)
    low_c, high_c = device._controller.sensors["tip"].range_c
    low_c += 0.25 if kind == "max6675" else 0.0
    for temperature_c in np.linspace(low_c, high_c, 60):
        device.sense("tip", float(temperature_c))
        last = next_steps(device, 2)[-1]
        assert last["reading_status"] == VALID
        assert last["reading_raw"] == np.floor(4 * temperature_c + 0.5)


def judged_6675(word: int) -> tuple[int, int]:
    """Status and raw code, after the data sheet's table of the bits."""
    body = word >> 1
    if body in {0, 0x7FFF}:
        return NO_ANSWER, 0
    if word >> 15 or word >> 1 & 1:
        return CRC, 0
    return (OPEN, 0) if word >> 2 & 1 else (VALID, word >> 3)


def judged_31855(word: int) -> tuple[int, int]:
    """Status and raw code, after the data sheet's memory map."""
    if word in {0, 0xFFFFFFFF}:
        return NO_ANSWER, 0
    fault, reasons = word >> 16 & 1, word & 7
    if word >> 17 & 1 or word >> 3 & 1 or bool(fault) != bool(reasons):
        return CRC, 0
    if fault:
        return (OPEN if reasons & 1 else SHORT), 0
    raw = word >> 18
    return VALID, raw - (1 << 14) if raw >> 13 else raw


def words(bits: int, often_zero: tuple[int, ...], count: int) -> list[int]:
    """Any word, and more of those that are almost good; all ones and zeros."""
    chance = random.Random(7)  # noqa: S311 - no secret
    mask = ~sum(1 << bit for bit in often_zero)
    drawn = [chance.getrandbits(bits) for _ in range(count)]
    good = [word & mask for word in drawn]
    flipped = [word ^ 1 << chance.choice(often_zero) for word in good]
    full = (1 << bits) - 1
    edges = [0, 1, 2, full, full - 1, full ^ 1 << (bits - 1), 1 << (bits - 1)]
    return [*edges, *drawn, *good, *flipped]


@pytest.mark.parametrize(
    ("kind", "bits", "often_zero", "judged"),
    [
        ("max6675", 16, (15, 2, 1), judged_6675),
        ("max31855", 32, (17, 16, 3, 2, 1, 0), judged_31855),
    ],
)
def test_any_answer(kind: str, bits: int, often_zero: tuple[int, ...], judged) -> None:
    device, chip = crucible(kind)
    raw, seen = next_steps(device)[-1]["reading_raw"], set()
    for word in words(bits, often_zero, 60):
        chip._word = lambda word=word: word  # type: ignore[method-assign,misc]
        last = next_steps(device)[-1]
        status, code = judged(word)
        raw = raw if status else code
        assert (last["reading_status"], last["reading_raw"]) == (status, raw), hex(word)
        seen.add(status)
    assert seen == ({VALID, NO_ANSWER, CRC, OPEN} | ({SHORT} if kind == "max31855" else set()))


@of_both
def test_each_wire(kind: str) -> None:
    """What a broken or shorted wire reads; which of them look alike."""
    wires = dict(zip(("select", "clock", "data"), PINS["uno"], strict=False))
    port = {"D10": "PB2", "D8": "PB0", "D12": "PB4"}
    for wire, level, status in (
        ("data", "low", SHORT),
        ("data", "high", NO_ANSWER),
        ("select", "high", NO_ANSWER),  # as a broken wire with a pull-up at the chip
        ("clock", "low", NO_ANSWER),  # the first bit is 0, and no other comes
    ):
        device, _ = crucible(kind)
        device.sense("tip", 100.0)
        assert next_steps(device, 2)["reading_status"].tolist() == [VALID] * 2
        device.avr.pins.drive(port[wires[wire]], level)  # type: ignore[arg-type]
        assert next_steps(device, 2)["reading_status"].tolist() == [status] * 2, wire
        device.avr.pins.drive(port[wires[wire]], None)
        assert next_steps(device, 3)["reading_status"][-1] == VALID


def test_a_select_that_is_held_low_is_a_short() -> None:
    """The chip then never lets go of the data line, whose first bit is 0."""
    for kind in KINDS:
        device, _ = crucible(kind)
        device.sense("tip", 100.0)
        next_steps(device, 2)
        device.avr.pins.drive("PB2", "low")
        device.avr.run(0.001)
        assert next_steps(device, 2)["reading_status"].tolist() == [SHORT] * 2


@of_both
def test_the_shortest_period(kind: str) -> None:
    """A reading in every step from the first that can have one; conversions come to their end."""
    period_s = {"max6675": 0.23, "max31855": 0.2}[kind]
    spec = spec_of(kind, period=f"{period_s * 1000:g} ms")
    device = AvrDevice(spec.controller, program(kind, period=f"{period_s * 1000:g} ms"))
    for turn in range(20):
        device.sense("tip", 100.0 + turn)
        device.advance((turn + 1) * period_s + 0.01)
    steps = device.steps("crucible")
    late = 0 if kind == "max6675" else 1
    assert steps["reading_status"].tolist() == [STALE] * late + [VALID] * (20 - late)
    wanted = [4 * (100 + max(turn - 1, 0)) for turn in range(20)]
    assert (abs(steps["reading_raw"] - np.array(wanted))[2:] <= 4).all()


def test_a_reset_of_the_processor_alone() -> None:
    """The chip goes on; the program waits for it as after power-up."""
    for kind in KINDS:
        device, _ = crucible(kind)
        device.sense("tip", 100.0)
        next_steps(device, 3)
        device.avr.reset("external")
        assert next_steps(device, 4)["reading_status"][-1] == VALID


@of_both
def test_replay(kind: str) -> None:
    """Valid readings, lost ones, faults: every member as the reference has it."""
    device, chip = crucible(kind)
    for turn in range(60):
        device.sense("tip", 20.0 + turn + 0.13 * turn % 3)
        chip.faults.corrupt_next = turn % 5 == 0
        next_steps(device)
    chip.faults.open = True
    next_steps(device, 10)
    steps = device.steps("crucible")
    assert OPEN in steps["fault.code"]
    result = replay(device._controller, steps)
    assert (result.ticks, result.mismatches, result.unchecked) == (len(steps), 0, ("fault.time_s",))


@of_both
def test_the_readme_says_how_to_wire_it(kind: str) -> None:
    """Without these a broken thermocouple is not seen, or a good one is taken for a short."""
    spec = spec_of(kind)
    text = render(plan_firmware(spec))["README.md"]
    rows = [line for line in text.splitlines() if "sensor `tip`" in line]
    assert [row.split(" = ")[0] for row in rows[:3]] == ["| D10", "| D8", "| D12"]
    wanted = {"max6675": "T- to its ground", "max31855": "must not touch ground"}
    assert wanted[kind] in rows[3]
    assert ("level shifter" in rows[0]) == (kind == "max31855")
