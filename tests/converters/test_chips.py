"""The converters against their data sheets, by way of a plain reader: chips.yaml, order by order,
and what takes more than its orders."""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from rig.firmware import SHARED, Small, running

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.shim import load
from heatwright.sim.native.spi import PHASES, Timing, _cycles
from heatwright.sim.sensors import max6675, max31855
from heatwright.sim.sensors.max6675 import Max6675
from heatwright.sim.sensors.max31855 import Max31855
from heatwright.sim.sensors.max31856 import TIMING, Max31856
from heatwright.sim.sensors.max31856 import code_of as code_31856
from heatwright.sim.sensors.spi_chip import Wires

WIRES = Wires("PB2", "PB0", "PB4", "PB3")
THREE_WIRES = Wires("PB2", "PB0", "PB4")
WRITE = 0x80
KINDS = {"max6675": Max6675, "max31855": Max31855, "max31856": Max31856}
BITS = {"max6675": 16, "max31855": 32}
REGISTERS = (
    "CR0", "CR1", "MASK", "CJHF", "CJLF", "LTHFTH", "LTHFTL", "LTLFTH", "LTLFTL", "CJTO",
    "CJTH", "CJTL", "LTCBH", "LTCBM", "LTCBL", "SR",
)  # fmt: skip
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
TYPES = "BEJKNRST"  # by their codes
AUTO, FIFTY = 0x80, 1
FIRST_S, NEXT_S = 0.185, 0.110


class Reader(Small):
    """Talks with a chip over three or four wires, by the variable `request` of registers.c."""

    def __init__(self) -> None:
        super().__init__((SHARED / "registers.c").read_text("utf-8"), seconds=0.0001)

    def exchange(self, *sent: int, mode: int = 1, **how: int) -> bytes:
        usual = {"late": 0, "bits_short": 0, "hold_ms": 0, "floats": 0} | how
        done = self["request.done"]
        for name, value in (usual | {"count": len(sent), "mode": mode}).items():
            self[f"request.{name}"] = value
        self["request.bytes"] = sent
        self["request.go"] = 1
        while self["request.done"] == done:
            self.avr.run(0.0001)
        return bytes(self["request.bytes"][: len(sent)])

    def read(self, bits: int, *, hold_ms: int = 0, pull_up: bool = True) -> int:
        """Read so many bits over three wires, most significant first; keep CS low for a while."""
        how = {"bits_short": -bits % 8, "hold_ms": hold_ms, "floats": not pull_up}
        *whole, last = self.exchange(*[0] * -(-bits // 8), mode=0, **how)
        return int.from_bytes(whole) << 8 - how["bits_short"] | last


class Bench:
    def __init__(self, kind: str, **more: Any) -> None:
        self.kind = kind
        by_registers = kind == "max31856"
        self.reader = Reader()
        self.run = self.reader.avr.run
        wires = WIRES if by_registers else THREE_WIRES
        self.chip: Any = KINDS[kind](self.reader.avr, wires, **more)

    def word(self, **how: Any) -> int:
        return self.reader.read(BITS[self.kind], **how)

    def read(self, register: str, count: int, **how: int) -> bytes:
        return self.reader.exchange(REGISTERS.index(register), *[0] * count, **how)[1:]

    def write(self, register: str, *values: int, **how: int) -> None:
        self.reader.exchange(REGISTERS.index(register) | WRITE, *values, **how)

    def begin(self, letter: str = "", *, cr0: int = AUTO | FIFTY) -> None:
        if letter:
            self.write("CR1", TYPES.index(letter))
        self.write("CR0", cr0)
        self.run(FIRST_S + 0.002)

    def celsius(self) -> float:
        """Return the tip's temperature, as the data sheet's memory maps have it."""
        if self.kind == "max31856":
            return (_signed(self.read("LTCBH", 3)) >> 5) / 128
        word = self.word()
        return (word >> 3 & 0xFFF) / 4 if self.kind == "max6675" else code_of(word) / 4

    def junction(self) -> float:
        return (_signed(self.read("CJTH", 2)) >> 2) / 64


def code_of(word: int) -> int:
    return _signed(word.to_bytes(4, "big")) >> 18


def _signed(found: bytes) -> int:
    return int.from_bytes(found, "big", signed=True)


SCRIPTS = yaml.safe_load(Path(__file__).with_name("chips.yaml").read_text("utf-8"))
EACH = [(kind, title) for kind, scripts in SCRIPTS.items() for title in scripts]


class Orders:
    def __init__(self, kind: str) -> None:
        self._bench: Any = Bench(kind)
        self._chip: Any = self._bench.chip

    def sense(self, celsius: str) -> None:
        self._chip.sense(float(celsius))

    def wait(self, seconds: str) -> None:
        self._bench.run(float(seconds))

    def hold(self, ms: str) -> None:
        self._bench.word(hold_ms=int(ms))

    def set(self, member: str, value: str) -> None:
        """Set what the chip is told by the test: a fault, a wire, its own temperature."""
        owner, _, name = member.rpartition(".")
        target = attrgetter(owner)(self._chip) if owner else self._chip
        assert hasattr(target, name)
        setattr(target, name, yaml.safe_load(value))

    def do(self, method: str, *values: str) -> None:
        getattr(self._chip, method)(*map(yaml.safe_load, values))

    def drive(self, pin: str, level: str) -> None:
        self._bench.reader.avr.pins.drive(pin, yaml.safe_load(level))

    def reads(self, celsius: str, within: str = "0") -> None:
        assert self._bench.celsius() == pytest.approx(float(celsius), rel=0, abs=float(within))

    def junction(self, celsius: str) -> None:
        assert self._bench.junction() == float(celsius)

    def bits(self, *words: str) -> None:
        """Compare the bits under a mask: of the answer, or of a register."""
        *register, mask, value = words
        found = self._bench.read(*register, 1)[0] if register else self._bench.word()
        assert found & int(mask, 16) == int(value, 16)

    def idles(self, level: str) -> None:
        assert bool(self._bench.reader["request.idle_high"]) == (level == "high")

    def write(self, register: str, *values: str) -> None:
        self._bench.write(register, *(int(value, 16) for value in values))

    def has(self, register: str, *values: str) -> None:
        """Compare registers from this one on."""
        due = POWER_ON if values == ("POWER_ON",) else bytes.fromhex("".join(values))
        assert self._bench.read(register, len(due)) == due

    def begin(self, cr0: str) -> None:
        self._bench.begin(cr0=int(cr0, 16))

    def is_(self, member: str, number: str) -> None:
        assert attrgetter(member)(self._chip) == int(number)


@pytest.mark.parametrize(("kind", "title"), EACH)
def test_it_does(kind: str, title: str) -> None:
    orders = Orders(kind)
    for step in SCRIPTS[kind][title].split(";"):
        order, *words = step.split()
        getattr(orders, "is_" if order == "is" else order)(*words)


FAULT, ALWAYS_ZERO = 1 << 16, 1 << 17 | 1 << 3
ALWAYS_ZERO_6675 = 0x8002
TOO_LONG_NS = 1e6


@pytest.fixture
def old() -> Bench:
    return Bench("max6675")


@pytest.fixture
def chip() -> Bench:
    return Bench("max31856")


CODES: dict[str, tuple[Callable[[float], int], int, dict[float, int]]] = {
    "max6675": (max6675.raw_code, 0xFFF, {
        -40: 0, 0: 0, 0.12: 0, 0.13: 1, 25: 100, 1023.75: 4095, 1200: 4095,
    }),
    "max31855": (max31855.raw_code, 0x3FFF, {
        1600.00: 0b0110_0100_0000_00, 1000.00: 0b0011_1110_1000_00, 100.75: 0b0000_0110_0100_11,
        25.00: 0b0000_0001_1001_00, 0.00: 0, -0.25: 0b1111_1111_1111_11,
        -1.00: 0b1111_1111_1111_00, -250.00: 0b1111_0000_0110_00,
    }),
    "max31855 itself": (max31855.internal_code, 0xFFF, {
        127.0: 0b0111_1111_0000, 100.5625: 0b0110_0100_1001, 25.0: 0b0001_1001_0000, 0.0: 0,
        -0.0625: 0b1111_1111_1111, -1.0: 0b1111_1111_0000, -20.0: 0b1110_1100_0000,
        -55.0: 0b1100_1001_0000,
    }),
    "max31856": (lambda celsius: code_31856(celsius, 2.0**-7), 0x7FFFF, {
        1600.0: 0b0110_0100_0000_0000_000, 1000.0: 0b0011_1110_1000_0000_000,
        100.9375: 0b0000_0110_0100_1111_000, 25.0: 0b0000_0001_1001_0000_000,
        0.0625: 0b0000_0000_0000_0001_000, 0.0: 0, -0.0625: 0b1111_1111_1111_1111_000,
        -0.25: 0b1111_1111_1111_1100_000, -1.0: 0b1111_1111_1111_0000_000,
        -250.0: 0b1111_0000_0110_0000_000,
    }),
}  # fmt: skip
"""What gives the codes, the bits of one, and codes by temperature: the data sheets' tables."""


@pytest.mark.parametrize("kind", CODES)
def test_codes_of_the_data_sheet(kind: str) -> None:
    code, mask, due = CODES[kind]
    for celsius, bits in due.items():
        found = code(celsius) if kind == "max6675" else code(celsius) & mask
        assert found == bits, celsius


def test_more_clocks_than_bits_bring_nothing(old: Bench) -> None:
    old.chip.sense(10.0)
    old.run(max6675.LONGEST_S)
    assert old.reader.read(24) == (40 << 3) << 8 | 0x1FF


def test_corrupted_answers(old: Bench) -> None:
    old.chip.sense(100.0)
    old.run(max6675.LONGEST_S)
    old.chip.faults.corrupt_next = 2
    wrong = [bool(old.word() & ALWAYS_ZERO_6675) for _ in range(3)]
    assert wrong == [True, True, False]
    old.chip.faults.corrupt_rate = 0.5
    assert 10 < sum(bool(old.word() & ALWAYS_ZERO_6675) for _ in range(40)) < 30


def test_two_chips_share_clock_and_data(old: Bench) -> None:
    other = max6675.Max6675(old.reader.avr, replace(THREE_WIRES, select="PB1"))
    old.reader.avr.pins.pull("PB1", "high")
    old.chip.sense(100.0)
    other.sense(900.0)
    old.run(max6675.LONGEST_S)
    assert (old.celsius(), other.reads) == (100.0, 0)


def test_what_can_be_corrupted_can_be_noticed() -> None:
    """Always one of the bits that are zero, or a fault without its reason, or the reverse."""
    small = Bench("max31855")
    small.run(max31855.POWER_UP_S + max31855.LONGEST_S)
    small.chip.faults.corrupt_rate = 1.0
    seen = {small.word() & (FAULT | ALWAYS_ZERO | 7) for _ in range(80)}
    assert seen == {FAULT, 1 << 17, 1 << 3, 1, 2, 4}


@pytest.mark.parametrize("mode", [1, 3])
def test_registers_are_read_and_written(chip: Bench, mode: int) -> None:
    """The clock's level at select is that of its rest: both modes will do."""
    assert chip.read("CR0", 16, mode=mode) == POWER_ON
    assert chip.read("LTHFTH", 3, mode=mode) == POWER_ON[5:8]
    chip.write("CR1", 0x47, 0xA5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, mode=mode)
    settings = [0, 0x47, 0xA5, 1, 2, 3, 4, 5, 6, 7]  # what is measured is not written
    assert chip.read("CR0", 16, mode=mode) == bytes([*settings, 0, 0, 0, 0, 0, 0])
    assert (chip.chip.orders, chip.chip.port.violations) == (1, 0)
    assert {"told", "kept"} <= set(chip.chip.port.phases)


@pytest.mark.parametrize("wrong", [{"bits_short": 1}, {"late": 1}])
def test_a_part_of_a_byte_and_one_that_is_late_are_not_understood(
    chip: Bench, wrong: dict[str, int]
) -> None:
    chip.write("CR1", 0x55, **wrong)
    assert chip.read("CR1", 1) == POWER_ON[1:2]


@pytest.mark.parametrize("phase", ["told", "kept"])
def test_what_it_is_told_must_stand(chip: Bench, phase: str) -> None:
    chip.write("CJTH", 0x55)
    assert chip.chip.port.violations == 0
    chip.chip.port.retime(replace(TIMING, **{phase: TOO_LONG_NS}))
    chip.write("CJTH", 0x55)
    phases = chip.chip.port.phases
    assert {name for name, seen in phases.items() if seen.violations} == {phase}


@pytest.mark.parametrize(
    ("filter_bit", "average", "first_s", "next_s"),
    [
        (FIFTY, 0, 0.185, 0.110), (FIFTY, 1, 0.225, 0.130), (FIFTY, 2, 0.305, 0.170),
        (FIFTY, 4, 0.785, 0.410), (FIFTY, 7, 0.785, 0.410), (0, 0, 0.155, 0.090),
        (0, 3, 0.155 + 7 / 30, 0.090 + 7 / 60),
    ],
)  # fmt: skip
def test_times(chip: Bench, filter_bit: int, average: int, first_s: float, next_s: float) -> None:
    chip.write("CR1", average << 4 | TYPES.index("K"))
    chip.write("CR0", AUTO | filter_bit)
    chip.chip.sense(100.0)
    chip.run(first_s - 0.004)
    assert chip.celsius() == 0.0
    chip.run(0.004)
    assert chip.celsius() != 0.0
    chip.chip.sense(200.0)
    chip.run(next_s - 0.004)
    before = chip.celsius()
    chip.run(0.004)
    assert chip.celsius() > before


RANGES_C = {
    "B": (250, 1820), "E": (-200, 1000), "J": (-210, 1200), "K": (-200, 1372), "N": (-200, 1300),
    "R": (-50, 1768), "S": (-50, 1768), "T": (-200, 400),
}  # fmt: skip


@pytest.mark.parametrize("letter", RANGES_C)
@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("junction_c", [0.0, 25.0, 61.015625])
def test_every_type_over_its_range(letter: str, share: float, junction_c: float) -> None:
    chip = Bench("max31856", wire=letter)
    low_c, high_c = RANGES_C[letter]
    temperature_c = low_c + share * (high_c - low_c)
    # At its ends a rounding error may count as outside; so does type B's, which hardly rises there.
    temperature_c = min(max(temperature_c, low_c + 0.05), high_c - 0.05)
    if letter == "B":
        temperature_c = max(temperature_c, 260.0)
    chip.chip.internal_c = junction_c
    chip.chip.sense(temperature_c)
    chip.begin(letter)
    assert chip.celsius() == pytest.approx(temperature_c, abs=1 / 256 + 1e-6)
    assert (chip.read("SR", 1), chip.junction()) == (b"\x00", junction_c)


def test_a_burst_is_of_one_moment(chip: Bench) -> None:
    """What it measures while it is selected shows with the next answer."""
    chip.begin("K")
    chip.chip.sense(500.0)
    chip.run(NEXT_S - 0.02)
    first = chip.read("LTCBH", 6, hold_ms=40)
    assert first[:3] == bytes([1, 0x40, 0x1F])  # 20 °C
    assert first[4:] == bytes([0x81, 3])  # behind the last register: the first
    assert chip.celsius() == 500.0


def test_damage_shows_in_the_settings(chip: Bench) -> None:
    chip.begin("K")
    sound = chip.read("CR0", 10)
    assert sound == bytes([0x81, 0x03, 0xFF, 0x7F, 0xC0, 0x7F, 0xFF, 0x80, 0, 0])
    chip.chip.faults.corrupt_next = 2
    answers = [chip.read("CR0", 16)[:10] for _ in range(3)]
    turned = [int.from_bytes(each, "big") ^ int.from_bytes(sound, "big") for each in answers]
    assert [each.bit_count() for each in turned] == [1, 1, 0]


# The slave's end of the wires: what it judges, what it drives, what it does when misused.


@pytest.mark.parametrize("phase", [*PHASES[:4], "hold", "idle"])
def test_a_phase_that_is_too_short_is_counted(old: Bench, phase: str) -> None:
    old.word()
    assert old.chip.port.violations == 0
    old.chip.port.retime(replace(max6675.TIMING, **{phase: TOO_LONG_NS}))
    old.word()
    phases = old.chip.port.phases
    assert {name for name, seen in phases.items() if seen.violations} == {phase}
    once = phase in {"setup", "hold", "idle"}
    assert phases[phase].violations == (1 if once else 16 if phase == "high" else 15)


def test_phases_are_measured(old: Bench) -> None:
    """As the log of the pins has them."""
    pins = old.reader.avr.pins
    select, clock = pins.watch(THREE_WIRES.select), pins.watch(THREE_WIRES.clock)
    old.word()
    old.word()
    phases = old.chip.port.phases
    assert set(phases) == set(PHASES) - {"told", "kept"}
    events = pins.take()
    down, up = edges(events, select)
    rises, falls = edges(events, clock)[::-1]
    first, last = rises[::16], falls[15::16]
    highs = falls - rises
    lows, periods = (np.delete(gaps, 15) for gaps in (rises[1:] - falls[:-1], np.diff(rises)))
    for name, cycles in (
        ("setup", first - down), ("high", highs), ("low", lows), ("period", periods),
        ("hold", up - last), ("idle", down[1:] - up[:-1]),
    ):  # fmt: skip
        assert phases[name].least == min(cycles) * 62.5
        assert phases[name].most == max(cycles) * 62.5
    assert 1000 - 4 * 62.5 < phases["read"].least < phases["read"].most < phases["low"].most


def edges(events: NDArray[Any], pin: int) -> tuple[NDArray[Any], NDArray[Any]]:
    of_pin = events[events["pin"] == pin]
    cycles = of_pin["cycle"].astype(int)
    return cycles[of_pin["state"] & 1 == 0], cycles[of_pin["state"] & 1 == 1]


def test_who_reads_too_early_reads_the_bit_before(old: Bench) -> None:
    old.chip.sense(341.25)  # 0101 0101 0101
    old.run(max6675.LONGEST_S)
    assert old.word() == 0b0010101010101001
    old.chip.port.retime(replace(max6675.TIMING, output=7000))
    late = old.word()
    assert late == 0b0001010101010100
    phases = old.chip.port.phases
    assert phases["read"].violations == 15


def test_the_first_bit_may_be_late(old: Bench) -> None:
    old.reader.avr.pins.drive("PB4", None)
    old.chip.sense(100.0)
    old.run(max6675.LONGEST_S)
    old.chip.port.retime(replace(max6675.TIMING, enable=1e5))
    assert (old.word(), old.chip.port.phases["read"].violations) == (0x8000 | 400 << 3 | 1, 1)


def test_twenty_megahertz_can_do_exactly_100_ns() -> None:
    """Two cycles of 50 ns; a rounding error must not ask for three."""
    shim = load()
    for clock_hz, cycles in ((20_000_000, 2), (16_000_000, 2), (8_000_000, 1), (10_000_000, 1)):
        timing = _cycles(Hw(shim.lib, shim.ffi, None, clock_hz), Timing())
        assert timing.high == cycles


def test_a_processor_that_drives_the_data_line_fights() -> None:
    avr = running(
        """int main(void) {
            PORTB = _BV(PB2); DDRB = _BV(PB2) | _BV(PB0);
            _delay_ms(250);
            PORTB |= _BV(PB4); DDRB |= _BV(PB4);
            PORTB &= ~_BV(PB2);
            _delay_us(2);
            (void)PINB;
            for (;;) {}
        }"""
    )
    chip = max6675.Max6675(avr, THREE_WIRES)
    avr.run(0.26)
    assert chip.reads == 1
    assert avr.pins.contention_cycles("PB4") > 0.005 * avr.clock_hz


def test_what_a_chip_raises_comes_out_of_the_run(old: Bench) -> None:
    class Broken:
        def selected(self, cycle: int) -> None:
            raise RuntimeError(f"broken when selected {cycle > 0}")

        def released(self, cycle: int) -> None:
            raise RuntimeError(f"broken when released {cycle > 0}")

    old.reader.avr.spi(THREE_WIRES, Broken())
    with pytest.raises(RuntimeError, match="broken when selected True"):
        old.word()


def test_too_many_chips(old: Bench) -> None:
    for _ in range(7):  # and `old`
        max6675.Max6675(old.reader.avr, THREE_WIRES)
    with pytest.raises(ValueError, match="too many SPI chips"):
        max6675.Max6675(old.reader.avr, THREE_WIRES)
