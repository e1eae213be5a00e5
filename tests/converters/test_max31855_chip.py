"""The MAX31855 against its data sheet, by way of a plain reader on a simulated processor."""

import pytest
from rig.chips import Reader

from heatwright.sim.sensors.max31855 import (
    LONGEST_S,
    POWER_UP_S,
    Max31855,
    internal_code,
    raw_code,
)

FAULT, SUPPLY, GROUND, OPEN = 1 << 16, 4, 2, 1
ALWAYS_ZERO = 1 << 17 | 1 << 3
FIRST_S = POWER_UP_S + LONGEST_S


def code(word: int) -> int:
    raw = word >> 18
    return raw - (1 << 14) if raw >> 13 else raw


@pytest.mark.parametrize(
    ("temperature_c", "bits"),
    [
        (1600.00, 0b01100100000000),
        (1000.00, 0b00111110100000),
        (100.75, 0b00000110010011),
        (25.00, 0b00000001100100),
        (0.00, 0),
        (-0.25, 0b11111111111111),
        (-1.00, 0b11111111111100),
        (-250.00, 0b11110000011000),
    ],
)
def test_codes_of_the_data_sheet(temperature_c: float, bits: int) -> None:
    assert raw_code(temperature_c) & 0x3FFF == bits


@pytest.mark.parametrize(
    ("temperature_c", "bits"),
    [
        (127.0, 0b011111110000),
        (100.5625, 0b011001001001),
        (25.0, 0b000110010000),
        (0.0, 0),
        (-0.0625, 0b111111111111),
        (-1.0, 0b111111110000),
        (-20.0, 0b111011000000),
        (-55.0, 0b110010010000),
    ],
)
def test_internal_codes_of_the_data_sheet(temperature_c: float, bits: int) -> None:
    assert internal_code(temperature_c) & 0xFFF == bits


@pytest.mark.parametrize("temperature_c", [-270.0, -0.25, 0.0, 1350.0, 1800.0])
def test_an_answer(reader: Reader, max31855: Max31855, temperature_c: float) -> None:
    max31855.sense(temperature_c)
    max31855.internal_c = 31.5
    reader.avr.run(FIRST_S)
    word = reader.read(32)
    assert code(word) == 4 * temperature_c
    assert word >> 4 & 0xFFF == 31.5 * 16
    assert word & (FAULT | ALWAYS_ZERO | 7) == 0
    assert max31855.port.violations == 0


def test_zeros_until_the_first_conversion(reader: Reader, max31855: Max31855) -> None:
    max31855.sense(100.0)
    reader.avr.run(FIRST_S - 0.002)
    assert reader.read(32) == 0
    reader.avr.run(0.002)
    assert code(reader.read(32)) == 400
    max31855.brown_out()
    assert reader.read(32) == 0


def test_it_converts_in_the_background(reader: Reader, max31855: Max31855) -> None:
    """Answers do not disturb it."""
    reader.avr.run(FIRST_S)
    max31855.sense(100.0)
    seen = []
    for _ in range(21):
        seen.append(code(reader.read(32)))
        reader.avr.run(0.01)
    changed = [turn for turn in range(1, 21) if seen[turn] != seen[turn - 1]]
    assert (seen[0], seen[-1], len(changed)) == (80, 400, 1)


def test_nothing_is_renewed_while_selected(reader: Reader, max31855: Max31855) -> None:
    reader.avr.run(FIRST_S + 0.001)
    max31855.sense(100.0)
    reader.avr.run(LONGEST_S - 0.02)
    reader.read(32, hold_ms=150)  # two conversions end meanwhile, and are lost
    assert code(reader.read(32)) == 80
    reader.avr.run(LONGEST_S)
    assert code(reader.read(32)) == 400


@pytest.mark.parametrize(("wire", "bit"), [("ground", GROUND), ("supply", SUPPLY)])
def test_a_thermocouple_that_touches(
    reader: Reader, max31855: Max31855, wire: str, bit: int
) -> None:
    max31855.shorted_to = wire  # type: ignore[assignment]
    reader.avr.run(FIRST_S)
    assert reader.read(32) & (FAULT | ALWAYS_ZERO | 7) == FAULT | bit
    max31855.shorted_to = None
    reader.avr.run(2 * LONGEST_S)
    assert reader.read(32) & (FAULT | 7) == 0


def test_an_open_thermocouple(reader: Reader, max31855: Max31855) -> None:
    max31855.faults.open = True
    reader.avr.run(FIRST_S)
    word = reader.read(32)
    assert word & (FAULT | ALWAYS_ZERO | 7) == FAULT | OPEN
    assert word >> 18 == 0x1FFF


def test_without_chip_there_are_ones(reader: Reader, max31855: Max31855) -> None:
    max31855.unplug()
    assert reader.read(32) == 0xFFFFFFFF


def test_slow_and_frozen(reader: Reader, max31855: Max31855) -> None:
    reader.avr.run(FIRST_S)
    assert code(reader.read(32)) == 80
    max31855.faults.slow = 1.5
    max31855.sense(100.0)
    reader.avr.run(0.14)
    assert code(reader.read(32)) == 80
    reader.avr.run(0.2)
    assert code(reader.read(32)) == 400
    max31855.faults.frozen = True
    max31855.sense(200.0)
    reader.avr.run(1.0)
    assert code(reader.read(32)) == 400


def test_what_can_be_corrupted_can_be_noticed(reader: Reader, max31855: Max31855) -> None:
    """Always one of the bits that are zero, or a fault without its reason, or the reverse."""
    reader.avr.run(FIRST_S)
    max31855.faults.corrupt_rate = 1.0
    seen = {reader.read(32) & (FAULT | ALWAYS_ZERO | 7) for _ in range(80)}
    assert seen == {FAULT, 1 << 17, 1 << 3, 1, 2, 4}
