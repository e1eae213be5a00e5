"""The MAX31856 against its data sheet, by way of a plain reader on a simulated processor."""

from dataclasses import replace
from itertools import pairwise

import pytest
from rig.chips import WIRES, RegisterReader

from heatwright.sim.sensors.max31856 import TIMING, Max31856, code_of

CR0, CR1, MASK, CJHF, CJLF, LTHFTH, LTHFTL, LTLFTH, LTLFTL, CJTO = range(10)
CJTH, CJTL, LTCBH, LTCBM, LTCBL, SR = range(10, 16)
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
AUTO, ONCE, TEST, NO_JUNCTION, KEEP, CLEAR, FIFTY = 0x80, 0x40, 0x10, 8, 4, 2, 1
CODES = {letter: code for code, letter in enumerate("BEJKNRST")}
FIRST_S, NEXT_S = 0.185, 0.110
TOO_LONG_NS = 1e6


@pytest.fixture
def reader() -> RegisterReader:
    return RegisterReader()


@pytest.fixture
def chip(reader: RegisterReader) -> Max31856:
    return Max31856(reader.avr, WIRES)


def celsius(reader: RegisterReader) -> float:
    word = int.from_bytes(reader.read(LTCBH, 3), "big", signed=True)
    return (word >> 5) / 128


def junction(reader: RegisterReader) -> float:
    """The cold junction's temperature, °C, of a chip that measures it."""
    return (int.from_bytes(reader.read(CJTH, 2), "big", signed=True) >> 2) / 64


def begin(reader: RegisterReader, letter: str = "K", *, cr0: int = AUTO | FIFTY) -> None:
    """Let it convert, and wait for the first one."""
    reader.write(CR1, CODES[letter])
    reader.write(CR0, cr0)
    reader.avr.run(FIRST_S + 0.002)


@pytest.mark.parametrize(
    ("temperature_c", "code"),
    [
        (1600.0, 0b0110_0100_0000_0000_000), (1000.0, 0b0011_1110_1000_0000_000),
        (100.9375, 0b0000_0110_0100_1111_000), (25.0, 0b0000_0001_1001_0000_000),
        (0.0625, 0b0000_0000_0000_0001_000), (0.0, 0), (-0.0625, 0b1111_1111_1111_1111_000),
        (-0.25, 0b1111_1111_1111_1100_000), (-1.0, 0b1111_1111_1111_0000_000),
        (-250.0, 0b1111_0000_0110_0000_000),
    ],
)  # fmt: skip
def test_codes_of_the_data_sheet(temperature_c: float, code: int) -> None:
    assert code_of(temperature_c, 2.0**-7) & 0x7FFFF == code


@pytest.mark.parametrize("mode", [1, 3])
def test_registers_after_power_up(reader: RegisterReader, chip: Max31856, mode: int) -> None:
    """The clock's level at select is that of its rest: both modes will do."""
    assert reader.read(CR0, 16, mode=mode) == POWER_ON
    assert reader.read(LTHFTH, 3, mode=mode) == POWER_ON[LTHFTH : LTHFTH + 3]
    assert chip.port.violations == 0


@pytest.mark.parametrize("mode", [1, 3])
def test_registers_are_written(reader: RegisterReader, chip: Max31856, mode: int) -> None:
    reader.write(CR1, 0x47, 0xA5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, mode=mode)
    assert reader.read(CR0, 16, mode=mode) == bytes(
        [0, 0x47, 0xA5, 1, 2, 3, 4, 5, 6, 7, 0, 0, 0, 0, 0, 0]
    )  # what is measured is not
    assert chip.orders == 1
    assert chip.port.violations == 0
    assert {"told", "kept"} <= set(chip.port.phases)


def test_the_cold_junction_can_be_told(reader: RegisterReader, chip: Max31856) -> None:
    reader.write(CR0, AUTO | FIFTY | NO_JUNCTION)
    reader.write(CJTH, 60, 0)
    chip.internal_c = 40.0
    chip.sense(40.0)
    reader.avr.run(FIRST_S)
    assert reader.read(CJTH, 2) == bytes([60, 0])
    assert celsius(reader) == pytest.approx(60.0, abs=0.01)


def test_a_register_takes_whole_bytes(reader: RegisterReader, chip: Max31856) -> None:
    reader.exchange(bytes([CR1 | 0x80, 0x55]), bits_short=1)
    assert reader.read(CR1, 1) == POWER_ON[CR1 : CR1 + 1]


def test_who_tells_too_late_is_not_understood(reader: RegisterReader, chip: Max31856) -> None:
    reader.exchange(bytes([CR1 | 0x80, 0x55]), late=1)
    assert reader.read(CR1, 1) == POWER_ON[CR1 : CR1 + 1]


@pytest.mark.parametrize("phase", ["told", "kept"])
def test_what_it_is_told_must_stand(reader: RegisterReader, chip: Max31856, phase: str) -> None:
    reader.write(CJTH, 0x55)
    assert chip.port.violations == 0
    chip.port.retime(replace(TIMING, **{phase: TOO_LONG_NS}))
    reader.write(CJTH, 0x55)
    phases = chip.port.phases
    assert {name for name, seen in phases.items() if seen.violations} == {phase}


def test_the_first_conversion_and_those_that_follow(reader: RegisterReader, chip: Max31856) -> None:
    chip.sense(300.0)
    reader.write(CR0, AUTO | FIFTY)
    reader.avr.run(FIRST_S - 0.002)
    assert celsius(reader) == 0.0
    reader.avr.run(0.002)
    assert celsius(reader) == 300.0
    seen = []
    for times in range(60):
        chip.sense(300.0 + times)
        seen.append(celsius(reader))
        reader.avr.run(0.01)
    changes = sum(one != other for one, other in pairwise(seen))
    assert 5 <= changes <= 6  # every 110 ms


@pytest.mark.parametrize(
    ("filter_bit", "average", "times_s"),
    [
        (FIFTY, 0, (0.185, 0.110)), (FIFTY, 1, (0.225, 0.130)), (FIFTY, 2, (0.305, 0.170)),
        (FIFTY, 4, (0.785, 0.410)), (FIFTY, 7, (0.785, 0.410)), (0, 0, (0.155, 0.090)),
        (0, 3, (0.155 + 7 / 30, 0.090 + 7 / 60)),
    ],
)  # fmt: skip
def test_times(
    reader: RegisterReader, chip: Max31856, filter_bit: int, average: int,
    times_s: tuple[float, float],
) -> None:  # fmt: skip
    first_s, next_s = times_s
    reader.write(CR1, average << 4 | CODES["K"])
    reader.write(CR0, AUTO | filter_bit)
    chip.sense(100.0)
    reader.avr.run(first_s - 0.004)
    assert celsius(reader) == 0.0
    reader.avr.run(0.004)
    assert celsius(reader) != 0.0
    chip.sense(200.0)
    reader.avr.run(next_s - 0.004)
    before = celsius(reader)
    reader.avr.run(0.004)
    assert celsius(reader) > before


def test_an_average_is_of_all_its_samples(reader: RegisterReader, chip: Max31856) -> None:
    """One in each period of the mains, the last ones before the conversion's end."""
    reader.write(CR1, 4 << 4 | CODES["K"])
    chip.sense(100.0)
    reader.write(CR0, AUTO | FIFTY)
    reader.avr.run(0.785 - 8.5 * 0.02)
    chip.sense(116.0)
    reader.avr.run(0.2)
    assert celsius(reader) == pytest.approx(108.0, abs=0.01)


def test_one_conversion_on_request(reader: RegisterReader, chip: Max31856) -> None:
    chip.sense(50.0)
    reader.write(CR0, ONCE | FIFTY)
    assert reader.read(CR0, 1) == bytes([FIFTY])
    reader.avr.run(FIRST_S)
    assert celsius(reader) == 50.0
    chip.sense(60.0)
    reader.avr.run(1.0)
    assert celsius(reader) == 50.0


def test_it_stops(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    chip.sense(99.0)
    reader.write(CR0, FIFTY)
    reader.avr.run(1.0)
    assert celsius(reader) == 20.0


def test_another_filter_while_it_converts_is_misuse(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    reader.write(CR0, AUTO | FIFTY)
    reader.write(CR1, 4)
    assert chip.misused == 0
    reader.write(CR0, AUTO)
    assert chip.misused == 1


@pytest.mark.parametrize("letter", CODES)
@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("junction_c", [0.0, 25.0, 61.015625])
def test_every_type_over_its_range(
    reader: RegisterReader, letter: str, share: float, junction_c: float
) -> None:
    chip = Max31856(reader.avr, WIRES, wire=letter)  # type: ignore[arg-type]
    low_c, high_c = {
        "B": (250, 1820), "E": (-200, 1000), "J": (-210, 1200), "K": (-200, 1372),
        "N": (-200, 1300), "R": (-50, 1768), "S": (-50, 1768), "T": (-200, 400),
    }[letter]  # fmt: skip
    temperature_c = low_c + share * (high_c - low_c)
    # At its ends a rounding error may count as outside; so does type B's, which hardly rises there.
    temperature_c = min(max(temperature_c, low_c + 0.05), high_c - 0.05)
    if letter == "B":
        temperature_c = max(temperature_c, 260.0)
    chip.internal_c = junction_c
    chip.sense(temperature_c)
    begin(reader, letter)
    assert celsius(reader) == pytest.approx(temperature_c, abs=1 / 256 + 1e-6)
    assert reader.read(SR, 1) == b"\x00"
    assert junction(reader) == junction_c


@pytest.mark.parametrize(
    ("wire", "setting", "temperature_c", "reads_c"),
    [("S", "K", 1000.0, 235.0), ("K", "S", 300.0, 1221.5), ("N", "K", 800.0, 684.0)],
)
def test_a_wrong_type_reads_wrong(
    reader: RegisterReader, wire: str, setting: str, temperature_c: float, reads_c: float
) -> None:
    """NIST's tables: S gives 9.587 mV at 1000 °C, K 12.209 at 300, N 28.455 at 800."""
    chip = Max31856(reader.avr, WIRES, wire=wire)  # type: ignore[arg-type]
    chip.internal_c = 0.0
    chip.sense(temperature_c)
    begin(reader, setting)
    assert celsius(reader) == pytest.approx(reads_c, abs=2.0)


def test_a_type_changes_with_the_next_conversion(reader: RegisterReader, chip: Max31856) -> None:
    chip.sense(300.0)
    begin(reader)
    reader.write(CR1, CODES["J"])
    assert celsius(reader) == 300.0
    reader.avr.run(NEXT_S)
    assert celsius(reader) < 250.0


@pytest.mark.parametrize(("temperature_c", "reads_c"), [(-230.0, -200.0), (1500.0, 1372.0)])
def test_beyond_the_range_of_its_type(
    reader: RegisterReader, temperature_c: float, reads_c: float
) -> None:
    chip = Max31856(reader.avr, WIRES, wire="K" if temperature_c < 0 else "E")
    chip.sense(temperature_c)
    begin(reader)
    assert reader.read(SR, 1)[0] & 0x40 == 0x40 * (temperature_c < 0)
    if temperature_c < 0:
        assert celsius(reader) == reads_c


def test_a_hot_chip(reader: RegisterReader, chip: Max31856) -> None:
    chip.internal_c = 130.0
    begin(reader)
    assert reader.read(SR, 1)[0] & 0x80


def test_an_offset_of_the_cold_junction(reader: RegisterReader, chip: Max31856) -> None:
    reader.write(CJTO, 0xF8)
    begin(reader)
    assert junction(reader) == 24.5
    assert celsius(reader) == pytest.approx(19.5, abs=0.02)


def test_an_open_thermocouple_is_found_by_the_sixteenth_conversion(
    reader: RegisterReader, chip: Max31856
) -> None:
    chip.sense(300.0)
    begin(reader, cr0=AUTO | TEST | FIFTY)
    chip.faults.open = True
    reader.avr.run(15 * NEXT_S)
    assert (reader.read(SR, 1), celsius(reader)) == (b"\x00", 300.0)
    reader.avr.run(0.016)
    assert reader.read(SR, 1) == b"\x01"
    chip.faults.open = False
    reader.avr.run(15 * NEXT_S)
    assert reader.read(SR, 1) == b"\x01"
    reader.avr.run(NEXT_S + 0.015)
    assert reader.read(SR, 1) == b"\x00"


def test_an_open_thermocouple_is_not_looked_for(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    chip.faults.open = True
    reader.avr.run(5.0)
    assert reader.read(SR, 1) == b"\x00"


def test_an_open_input_at_its_bias_reads_the_cold_junction(
    reader: RegisterReader, chip: Max31856
) -> None:
    chip.sense(300.0)
    chip.held = False
    begin(reader)
    chip.faults.open = True
    reader.avr.run(NEXT_S)
    assert celsius(reader) == pytest.approx(25.0, abs=0.01)


def test_beyond_its_supply_it_stands_still(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    chip.beyond_supply = True
    chip.sense(77.0)
    assert reader.read(SR, 1) == b"\x02"
    reader.avr.run(1.0)
    assert celsius(reader) == 20.0
    chip.beyond_supply = False
    reader.avr.run(NEXT_S)
    assert (reader.read(SR, 1), celsius(reader)) == (b"\x00", 77.0)


def test_faults_stay_where_that_is_asked_for(reader: RegisterReader, chip: Max31856) -> None:
    chip.internal_c = 130.0
    begin(reader, cr0=AUTO | KEEP | FIFTY)
    assert reader.read(SR, 1)[0] & 0x80
    chip.internal_c = 25.0
    reader.avr.run(NEXT_S)
    kept = reader.read(SR, 1)[0]
    assert kept & 0x80
    reader.write(CR0, AUTO | KEEP | CLEAR | FIFTY)
    assert reader.read(SR, 1) == b"\x00"
    assert reader.read(CR0, 1) == bytes([AUTO | KEEP | FIFTY])


@pytest.mark.parametrize(
    ("register", "value", "bit"),
    [(CJHF, 20, 0x20), (CJLF, 30, 0x10), (LTHFTH, 0, 0x08), (LTLFTH, 0x10, 0x04)],
)
def test_thresholds(
    reader: RegisterReader, chip: Max31856, register: int, value: int, bit: int
) -> None:
    reader.write(register, value)
    begin(reader)
    chip.sense(100.0)
    reader.avr.run(NEXT_S)
    assert reader.read(SR, 1)[0] == bit


def test_a_burst_is_of_one_moment(reader: RegisterReader, chip: Max31856) -> None:
    """What it measures while it is selected shows with the next answer."""
    begin(reader)
    chip.sense(500.0)
    reader.avr.run(NEXT_S - 0.02)
    first = reader.exchange(bytes([LTCBH, *[0] * 6]), hold_ms=40)[1:]
    assert first[:3] == bytes([1, 0x40, 0x1F])  # 20 °C
    assert first[4:] == bytes([0x81, 3])  # behind the last register: the first
    assert celsius(reader) == 500.0


def test_a_break_of_its_supply(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    chip.brown_out()
    assert reader.read(CR0, 16) == POWER_ON
    reader.avr.run(1.0)
    assert celsius(reader) == 0.0


def test_frozen_slow_dumb(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    chip.faults.frozen = True
    chip.sense(90.0)
    reader.avr.run(1.0)
    assert celsius(reader) == 20.0
    chip.faults.frozen = False
    chip.faults.slow = 3.0
    reader.avr.run(1.5 * NEXT_S)
    assert celsius(reader) == 20.0
    reader.avr.run(2 * NEXT_S)
    assert celsius(reader) == 90.0
    chip.faults.dumb = True
    assert reader.read(CR0, 16) == bytes(16)
    reader.write(CR0, 0)
    chip.faults.dumb = False
    assert reader.read(CR0, 1) == bytes([AUTO | FIFTY])


def test_damage_shows_in_the_settings(reader: RegisterReader, chip: Max31856) -> None:
    begin(reader)
    sound = reader.read(CR0, 10)
    assert sound == bytes([0x81, 0x03, 0xFF, 0x7F, 0xC0, 0x7F, 0xFF, 0x80, 0, 0])
    chip.faults.corrupt_next = 2
    answers = [reader.read(CR0, 16)[:10] for _ in range(3)]
    turned = [int.from_bytes(each, "big") ^ int.from_bytes(sound, "big") for each in answers]
    assert [each.bit_count() for each in turned] == [1, 1, 0]


def test_the_bits_below_the_temperatures_say_nothing(
    reader: RegisterReader, chip: Max31856
) -> None:
    chip.sense(25.0)
    assert reader.read(CR0, 16) == POWER_ON
    begin(reader)
    answer = reader.read(CR0, 16)
    assert (answer[LTCBL] & 0x1F, answer[CJTL] & 3) == (0x1F, 3)


def test_without_chip_there_are_ones(reader: RegisterReader, chip: Max31856) -> None:
    chip.unplug()
    assert reader.read(LTCBH, 4) == b"\xff" * 4
    chip.plug()
    assert reader.read(CR0, 16) == POWER_ON


@pytest.mark.parametrize("level", ["low", "high"])
def test_a_shorted_input(reader: RegisterReader, chip: Max31856, level: str) -> None:
    """Low, every read begins with the first register; high, everything is an order."""
    begin(reader)
    reader.avr.pins.drive("PB3", level)  # type: ignore[arg-type]
    found = reader.read(LTCBH, 4)
    assert found == (bytes([0x81, 3, 0xFF, 0x7F]) if level == "low" else b"\xff" * 4)
