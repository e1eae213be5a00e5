"""The MAX6675 against its data sheet, by way of a plain reader on a simulated processor."""

from dataclasses import replace

import pytest
from rig.chips import THREE_WIRES as WIRES
from rig.chips import Reader

from heatwright.sim.sensors.max6675 import LONGEST_S, Max6675, raw_code

OPEN, ALWAYS_ZERO = 0x0004, 0x8002


def code(word: int) -> int:
    return word >> 3 & 0xFFF


@pytest.mark.parametrize(
    ("temperature_c", "raw"),
    [(-40, 0), (0, 0), (0.12, 0), (0.13, 1), (25, 100), (1023.75, 4095), (1200, 4095)],
)
def test_codes(temperature_c: float, raw: int) -> None:
    assert raw_code(temperature_c) == raw


def test_an_answer(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(700.0)
    reader.avr.run(LONGEST_S)
    assert reader.read(16) == 2800 << 3 | 1  # D0 is three-state: our pull-up
    reader.avr.run(LONGEST_S)
    assert reader.read(16, pull_up=False) & ~1 == 2800 << 3
    assert max6675.port.violations == 0
    assert max6675.reads == 2


def test_more_clocks_than_bits_bring_nothing(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(10.0)
    reader.avr.run(LONGEST_S)
    assert reader.read(24) == (40 << 3) << 8 | 0x1FF


def test_a_conversion_needs_its_time_with_cs_high(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S - 0.001)
    assert code(reader.read(16)) == 0
    for _ in range(5):  # each answer ends the conversion under way
        reader.avr.run(LONGEST_S - 0.001)
        assert code(reader.read(16)) == 0
    reader.avr.run(LONGEST_S)
    assert code(reader.read(16)) == 400


def test_no_conversion_while_selected(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.read(16, hold_ms=250)
    assert code(reader.read(16)) == 0
    reader.avr.run(LONGEST_S)
    assert code(reader.read(16)) == 400


def test_the_last_conversion_that_ended_counts(reader: Reader, max6675: Max6675) -> None:
    """It converts again and again, and takes the temperature as it begins."""
    max6675.sense(100.0)
    reader.avr.run(0.1)
    max6675.sense(200.0)
    reader.avr.run(0.2)
    max6675.sense(300.0)
    reader.avr.run(0.1)
    assert code(reader.read(16)) == 400
    max6675.sense(300.0)
    reader.avr.run(2 * LONGEST_S + 0.001)
    assert code(reader.read(16)) == 1200


def test_an_open_thermocouple(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    max6675.faults.open = True
    reader.avr.run(LONGEST_S)
    assert reader.read(16) & (OPEN | ALWAYS_ZERO) == OPEN


def test_without_chip_there_are_ones(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.unplug()
    assert reader.read(16) == 0xFFFF
    max6675.plug()
    assert code(reader.read(16)) == 0
    reader.avr.run(LONGEST_S)
    assert code(reader.read(16)) == 400


def test_plugged_in_and_pulled_out_while_selected(reader: Reader, max6675: Max6675) -> None:
    """What is left of the wires' levels does not matter: it starts with the next answer."""
    max6675.unplug()
    max6675.unplug()
    reader.avr.pins.drive("PB2", "low")
    max6675.plug()
    assert max6675.reads == 1
    max6675.unplug()
    reader.avr.pins.drive("PB2", None)
    max6675.plug()
    max6675.sense(50.0)
    reader.avr.run(2 * LONGEST_S)
    assert code(reader.read(16)) == 200


@pytest.mark.parametrize(("level", "word"), [("low", 0), ("high", 0xFFFF)])
def test_a_shorted_data_line(reader: Reader, max6675: Max6675, level: str, word: int) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.short(level)  # type: ignore[arg-type]
    assert reader.read(16) == word
    assert reader.field("idle_high") == (level == "high")
    max6675.short(None)
    reader.avr.run(LONGEST_S)
    assert code(reader.read(16)) == 400


def test_a_chip_without_clock_drives_zeros(reader: Reader, max6675: Max6675) -> None:
    """Not even D0 is let go; what tells it from a short is that the line idles high."""
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.faults.dumb = True
    assert reader.read(16) == 0
    assert reader.field("idle_high")


def test_a_break_of_its_supply(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.brown_out()
    assert code(reader.read(16)) == 0


def test_corrupted_answers(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.faults.corrupt_next = 2
    wrong = [bool(reader.read(16) & ALWAYS_ZERO) for _ in range(3)]
    assert wrong == [True, True, False]
    max6675.faults.corrupt_rate = 0.5
    assert 10 < sum(bool(reader.read(16) & ALWAYS_ZERO) for _ in range(40)) < 30


def test_a_frozen_and_a_slow_chip(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    reader.read(16)
    max6675.faults.frozen = True
    max6675.sense(300.0)
    reader.avr.run(1.0)
    assert code(reader.read(16)) == 400
    max6675.faults.frozen = False
    max6675.faults.slow = 1.5
    reader.avr.run(1.4 * LONGEST_S)
    assert code(reader.read(16)) == 400
    reader.avr.run(1.5 * LONGEST_S)
    assert code(reader.read(16)) == 1200


def test_it_remembers_no_more_than_it_needs(reader: Reader, max6675: Max6675) -> None:
    for turn in range(100):
        max6675.sense(float(turn))
        reader.avr.run(0.1)
    assert len(max6675._past) < 25


def test_two_chips_share_clock_and_data(reader: Reader, max6675: Max6675) -> None:
    other = Max6675(reader.avr, replace(WIRES, select="PB1"))
    reader.avr.pins.pull("PB1", "high")
    max6675.sense(100.0)
    other.sense(900.0)
    reader.avr.run(LONGEST_S)
    assert code(reader.read(16)) == 400
    assert other.reads == 0
