"""ADC, EEPROM, pins and the outputs of timers: times and corners of the part."""

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, Small, running

from heatwright.sim.native.analog import millivolts
from heatwright.sim.native.pins import Source, pin_name, pin_number

PARTS = pytest.mark.parametrize("mcu", ["atmega328p", "atmega32", "atmega16"])
CODES = (0, 1, 131, 511, 512, 1022, 1023)

CONVERTER = """
volatile uint16_t code, cycles; volatile uint8_t mux, high;
int main(void) {
    ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0); TCCR1B = _BV(CS10);
    for (;;) {
        ADMUX = mux; TCNT1 = 0; ADCSRA |= _BV(ADSC);
        while (ADCSRA & _BV(ADSC)) {}
        cycles = TCNT1; if (mux & _BV(ADLAR)) high = ADCH; else code = ADC;
    }
}
"""
AVCC, AREF, INTERNAL, LEFT = 0x40, 0x00, 0xC0, 0x20


@PARTS
def test_each_code_has_its_voltages_on_every_channel(mcu: str) -> None:
    """code = floor(1024 V / Vref): the whole width of a code gives that code (data sheet)."""
    adc, width = Small(CONVERTER, mcu=mcu, seconds=0.001), 5000 / 1024
    for channel in range(8):
        adc["mux"] = AVCC | channel
        for code in CODES:
            for place in (0.001, 0.5, 0.999):
                adc.avr.adc.set(channel, (code + place) * width)
                adc.avr.run(0.0005)
                assert adc["code"] == code
            assert (code + 0.5) * width == millivolts(code)
            adc.avr.adc.set(channel, 2500)  # the channel's alone


@PARTS
def test_a_conversion_takes_thirteen_clocks_and_its_interrupt_comes_with_the_result(
    mcu: str,
) -> None:
    adc = Small(CONVERTER, mcu=mcu, seconds=0.01)
    assert adc["cycles"] == pytest.approx(13 * 128, abs=12)
    assert adc.avr.adc.conversions == pytest.approx(0.01 * CLOCK_HZ / (13 * 128), abs=8)
    adc = Small(
        """volatile uint16_t code, cycles;
        ISR(ADC_vect) { cycles = TCNT1; code = ADC; TCNT1 = 0; ADCSRA |= _BV(ADSC); }
        int main(void) {
            ADMUX = _BV(REFS0) | 5; TCCR1B = 1;
            ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADSC) | 7; sei(); for (;;) {}
        }""",
        mcu=mcu,
    )
    adc.avr.adc.set(5, millivolts(512))
    adc.avr.run(0.001)
    assert (adc["code"], adc["cycles"]) == (512, pytest.approx(13 * 128, abs=40))


@PARTS
def test_the_references(mcu: str) -> None:
    adc = Small(CONVERTER, mcu=mcu, seconds=0.001)
    adc.avr.adc.reference(aref_mv=4096, avcc_mv=5000)
    adc.avr.adc.set(2, 1000.5)
    internal = 930 if mcu == "atmega328p" else 400  # 1.1 V; 2.56 V
    for reference, code in ((AREF, 250), (AVCC, 204), (INTERNAL, internal)):
        adc["mux"] = reference | 2
        adc.avr.run(0.001)
        assert adc["code"] == pytest.approx(code, abs=1 if reference == INTERNAL else 0)


def test_the_voltage_is_taken_when_the_conversion_starts() -> None:
    adc = Small(
        """volatile uint16_t code;
        int main(void) {
            ADMUX = _BV(REFS0); ADCSRA = 0x87; ADCSRA |= _BV(ADSC); _delay_ms(1);
            ADMUX |= 1; code = ADC; for (;;) {}
        }"""
    )
    for seconds, channel, code in ((0, 0, 300), (0, 1, 700), (0.0005, 0, 900)):
        adc.avr.run(seconds)
        adc.avr.adc.set(channel, millivolts(code))
    adc.avr.run(0.01)
    assert adc["code"] == 300


def test_left_adjusted_results_need_the_high_byte_only_and_clipped_voltages() -> None:
    adc = Small(CONVERTER, seconds=0.001)
    volts = ((0, 0), (millivolts(400), 400), (5001, 1023), (12_000, 1023), (-50, 0))
    for voltage_mv, code in volts:
        adc.avr.adc.set(0, voltage_mv)
        for adjust in (0, LEFT):
            adc["mux"] = AVCC | adjust
            adc.avr.run(0.001)
        assert (adc["code"], adc["high"]) == (code, code >> 2)


WRITER = """
volatile uint8_t written;
int main(void) {
    for (uint8_t i = 0; i < 8; i++) { eeprom_write_byte((uint8_t *)(10 + i), 0x30 + i); written++; }
    eeprom_busy_wait(); written = 0xff; for (;;) {}
}
"""
BYTE_S = {"atmega328p": 0.0033, "atmega32": 0.0085, "atmega16": 0.0085}
"""Data sheets, tables "EEPROM Programming Time"."""


@PARTS
def test_an_eeprom_byte_takes_its_time(mcu: str) -> None:
    writer = Small(WRITER, mcu=mcu)
    for count in range(1, 9):
        writer.avr.run(BYTE_S[mcu])
        assert writer["written"] in {count, count + 1}
    assert writer.avr.eeprom.writing is not None
    writer.avr.run(0.001)
    assert (writer["written"], writer.avr.eeprom.writing) == (0xFF, None)
    assert writer.avr.eeprom.contents[9:19] == b"\xff01234567\xff"
    assert (writer.avr.eeprom.writes, writer.avr.eeprom.violations) == (8, 0)


@PARTS
def test_the_ready_interrupt_comes_as_long_as_nothing_is_written(mcu: str) -> None:
    old = ("MASTER=EEMWE", "START=EEWE", "READY=EE_RDY_vect")
    new = ("MASTER=EEMPE", "START=EEPE", "READY=EE_READY_vect")
    writer = Small(
        """
        volatile uint8_t next;
        ISR(READY) {
            if (next == 10) { EECR &= ~_BV(EERIE); return; }
            EEAR = E2END - 9 + next; EEDR = next; next++;
            EECR |= _BV(MASTER); EECR |= _BV(START);
        }
        int main(void) { EECR |= _BV(EERIE); sei(); for (;;) {} }""",
        *(f"-D{each}" for each in (new if mcu == "atmega328p" else old)),
        mcu=mcu,
    )
    for written in range(1, 11):
        writer.avr.run(BYTE_S[mcu])
        assert writer["next"] == pytest.approx(min(written + 1, 10), abs=1)
    writer.avr.run(0.01)
    size = 512 if mcu == "atmega16" else 1024
    assert writer.avr.eeprom.contents == b"\xff" * (size - 10) + bytes(range(10))
    assert (writer.avr.eeprom.writes, writer.avr.eeprom.violations) == (10, 0)


def test_a_power_cut_leaves_the_byte_undefined_and_the_rest_as_it_was_a_reset_nothing() -> None:
    writer = Small(WRITER)
    writer.avr.eeprom.contents = bytes([1]) * 1024
    writer.avr.run(0.0033 * 2.5)
    writing = writer.avr.eeprom.writing
    assert writing is not None
    assert (writing.address, writing.old, writing.new) == (12, 1, 0x32)
    for undefined in (0, 0x55, 0xFF):
        left = writer.avr.eeprom.after_power_cut(undefined)
        assert left[10:14] == bytes([0x30, 0x31, undefined, 1])
        assert left[:10] + left[14:] == bytes([1]) * 1020
    writer.avr.reset()
    assert writer.avr.eeprom.writing is not None
    assert writer.avr.eeprom.contents[10:13] == b"\x30\x31\x32"


def test_access_during_a_write_is_ignored_and_counted() -> None:
    program = Small(
        """EEAR = 5; EEDR = 0x77; EECR = _BV(EEMPE); EECR = _BV(EEMPE) | _BV(EEPE);
        EEAR = 6; EEDR = 0x11; EECR |= _BV(EERE); PORTB = EEDR;""",
        seconds=0.01,
    )
    assert (program.avr.eeprom.contents[5:7], program.avr.eeprom.violations) == (b"\x77\xff", 1)
    assert program.avr.read_ram(0x25, 1) == b"\x11"


@pytest.mark.parametrize(("mode", "result"), [(0, 0x0F), (1, 0xFF), (2, 0x05)])
def test_eeprom_programming_modes(mode: int, result: int) -> None:
    program = Small(f"EEAR = 5; EEDR = 0x0f; EECR = _BV(EEMPE) | {mode} << 4; EECR |= _BV(EEPE);")
    program.avr.eeprom.contents = bytes([0x55]) * 1024
    program.avr.run(0.01)
    assert program.avr.eeprom.contents[5] == result


def test_a_program_brings_its_eeprom() -> None:
    program = Small("static uint8_t kept[3] EEMEM = {1, 2, 3}; PORTB = eeprom_read_byte(kept);")
    assert program.avr.eeprom.contents[:4] == b"\x01\x02\x03\xff"
    with pytest.raises(ValueError, match="1024 bytes, not 1025"):
        program.avr.eeprom.contents = bytes(1025)


def states(avr: object) -> list[tuple[int, Source]]:
    events = avr.pins.take()  # type: ignore[attr-defined]
    return [(int(state) & 1, Source(int(state) >> 1)) for state in events["state"]]


def test_names_of_pins() -> None:
    assert pin_number("PB5") == 13
    assert [pin_name(pin_number(name)) for name in ("PA0", "PD3", "PL7")] == ["PA0", "PD3", "PL7"]
    for wrong in ("D3", "PB8", "PM0", "", "PB", "PBB"):
        with pytest.raises(ValueError, match="not a pin"):
            pin_number(wrong)
    with pytest.raises(ValueError, match="no pin PA0"):
        running("int main(void) { for (;;) {} }").pins.watch("PA0")


def test_every_driver_in_its_order_of_strength() -> None:
    """A pin that floats keeps its level."""
    avr = running("PORTB = 1; DDRB = 1; PORTB = 0; DDRB = 0; PORTB = 1; PORTB = 0; PORTB = 1;")
    avr.pins.watch("PB0")
    avr.run(0.001)
    assert states(avr) == [
        (1, Source.PULL_UP), (1, Source.MCU), (0, Source.MCU), (0, Source.FLOATING),
        (1, Source.PULL_UP), (1, Source.FLOATING), (1, Source.PULL_UP),
    ]  # fmt: skip
    avr.pins.pull("PB0", "low")
    avr.pins.drive("PB0", "high")
    avr.pins.drive("PB0", None)
    avr.pins.pull("PB0", None)
    due = [(0, Source.RESISTOR), (1, Source.OTHERS), (0, Source.RESISTOR), (1, Source.PULL_UP)]
    assert states(avr) == due


def test_contention_is_counted() -> None:
    avr = running("DDRB = 1; PORTB = 1;")
    avr.pins.drive("PB0", "low")
    avr.run(0.01)
    assert avr.pins.contention_cycles("PB0") == pytest.approx(0.01 * CLOCK_HZ, rel=0.01)
    assert not avr.pins.level("PB0")


def test_high_time_is_exact() -> None:
    on, off = (f"PINB = 1; __builtin_avr_delay_cycles({each});" for each in (997, 2993))
    avr = running(f"DDRB = 1; for (;;) {{ {on} {off} }}")
    number = avr.pins.watch("PB0")
    avr.run_to(100_000)
    start, high = avr.cycle, avr.pins.high_cycles(number)
    avr.run_to(start + 4_000_000)
    edges = avr.pins.take()
    is_high = (edges["state"] & 1).astype(bool)
    within = np.append(edges["cycle"].astype(int), avr.cycle).clip(min=start)
    assert avr.pins.high_cycles(number) - high == np.diff(within)[is_high].sum()
    assert avr.pins.rises(number) == is_high.sum()


OPEN_DRAIN = """
volatile uint8_t released, answered;
int main(void) {
    DDRB = 1; DDRB = 0; _delay_us(1); released = PINB & 1;
    DDRB = 1; DDRB = 0; _delay_us(1); answered = PINB & 1;
    for (;;) {}
}
"""


def test_a_chip_in_python_hears_all_edges_but_its_own_and_may_hold_the_line() -> None:
    master = Small(OPEN_DRAIN)
    pins, heard = master.avr.pins, list[tuple[int, int]]()

    def hear(low: int, cycle: int) -> None:
        heard.append((low, cycle))
        if len(heard) == 4:
            pins.hold("PB0", True)

    pins.pull("PB0", "high")
    pins.listen("PB0", hear)
    master.avr.run(0.001)
    assert [low for low, _ in heard] == [1, 0, 1, 0]
    assert heard[1][1] - heard[0][1] == 1  # an OUT takes a cycle
    assert (master["released"], master["answered"]) == (1, 0)
    assert (pins.level("PB0"), pins.source("PB0")) == (False, Source.OTHERS)
    pins.hold("PB0", False)
    assert pins.level("PB0")
    assert len(heard) == 4


def test_what_such_a_chip_raises_ends_the_run() -> None:
    master = Small(OPEN_DRAIN)
    master.avr.pins.listen("PB0", lambda low, cycle: [].pop(low and cycle))
    with pytest.raises(IndexError):
        master.avr.run(0.001)
    with pytest.raises(ValueError, match="no pin PA0"):
        master.avr.pins.listen("PA0", print)


def test_a_reset_lets_go_of_the_pins_at_once() -> None:
    avr = running("_delay_ms(1); DDRD = 8; PORTD = 8; wdt_enable(WDTO_30MS);")
    avr.pins.pull("PD3", "low")
    avr.pins.watch("PD3")
    avr.run(0.1)
    resets, events = avr.take_resets(), avr.pins.take()
    assert len(resets) > 1
    for reset in resets:
        after = events[events["cycle"] == reset["cycle"]]
        assert [int(state) for state in after["state"]] == [Source.RESISTOR << 1]


TIMERS = {
    # Part, pin, counts, prescaler, set-up, compare register.
    "timer 2, fast, 8 bits": (
        "atmega328p", "PD3", 256, 8, "TCCR2A = 0x03 | COM << 4; TCCR2B = 0x02;", "OCR2B"),
    "timer 1, mode 14": (
        "atmega328p", "PB1", 1000, 1, "ICR1 = 999; TCCR1A = 0x02 | COM << 6; TCCR1B = 0x19;",
        "OCR1A"),
    "timer 1, mode 15": (
        "atmega328p", "PB2", 400, 8, "OCR1A = 399; TCCR1A = 0x03 | COM << 4; TCCR1B = 0x1a;",
        "OCR1B"),
    "timer 0, mode 7": (
        "atmega328p", "PD5", 100, 64, "OCR0A = 99; TCCR0A = 0x03 | COM << 4; TCCR0B = 0x0b;",
        "OCR0B"),
} | {
    f"{mcu}, {compare}": (mcu, pin, counts, prescaler, setup, compare)
    for mcu in ("atmega32", "atmega16")
    for pin, counts, prescaler, setup, compare in (
        ("PB3", 256, 8, "TCCR0 = _BV(WGM01) | _BV(WGM00) | COM << 4 | 2;", "OCR0"),
        ("PD7", 256, 32, "TCCR2 = _BV(WGM21) | _BV(WGM20) | COM << 4 | 3;", "OCR2"),
        ("PD5", 1000, 1, "ICR1 = 999; TCCR1A = 2 | COM << 6; TCCR1B = 0x19;", "OCR1A"),
        ("PD4", 1000, 8, "ICR1 = 999; TCCR1A = 2 | COM << 4; TCCR1B = 0x1a;", "OCR1B"),
    )
}  # fmt: skip


@pytest.mark.parametrize("timer", TIMERS)
@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99, 1.0])
def test_fast_pwm(timer: str, inverted: bool, share: float) -> None:
    """High for OCR + 1 of TOP + 1 counts; at TOP constantly, without a gap (data sheets)."""
    mcu, pin, counts, prescaler, setup, compare = TIMERS[timer]
    value = min(round(share * counts), counts - 1)
    source = f"DDRB = DDRD = 0xff; {setup} {compare} = {value}; for (;;) PORTC ^= 0x20;"
    avr = running(source, f"-DCOM={3 if inverted else 2}", mcu=mcu)
    number, period = avr.pins.watch(pin), counts * prescaler
    avr.run_to(10 * period)
    avr.pins.take()
    start, high = avr.cycle, avr.pins.high_cycles(number)
    avr.run_to(start + 200 * period)
    on = (avr.pins.high_cycles(number) - high) / (avr.cycle - start)
    expected = (value + 1) / counts
    assert on == pytest.approx(1 - expected if inverted else expected, abs=1 / 200)
    edges = avr.pins.take()["cycle"].astype(int)
    assert len(edges) == (0 if value == counts - 1 else pytest.approx(400, abs=3))
    assert np.all(abs(np.diff(edges[::2]) - period) <= 4)


def test_writing_the_port_does_not_disturb_a_timers_pin() -> None:
    """The display shares port D with the heater: simavr makes false edges there."""
    setup = "DDRD = 0xff; OCR2B = 127; TCCR2A = 0x23; TCCR2B = 0x06;"
    avr = running(f"{setup} for (;;) PIND = 0xf0;")
    avr.pins.watch("PD3")
    avr.run(0.1)
    gaps = set(np.diff(avr.pins.take()["cycle"].astype(int)[2:]).tolist())
    assert all(abs(gap - 128 * 256) < 20 for gap in gaps), gaps


def test_a_pin_to_which_two_timers_lead() -> None:
    """It belongs to the one that is connected: timer 1's channel C is set up after timer 0 is."""
    avr = running(
        """DDRB = 0x80; TCCR0A = 0x83; OCR0A = 63; TCCR0B = 2;
        ICR1 = 999; TCCR1A = 0x82; TCCR1B = 0x19; OCR1A = 500;""",
        mcu="atmega2560",
    )
    number = avr.pins.watch("PB7")
    avr.run(0.001)
    before = avr.pins.high_cycles(number)
    avr.run(256 * 8 * 10 / CLOCK_HZ)
    assert avr.pins.high_cycles(number) - before == pytest.approx(64 * 8 * 10, abs=4)
