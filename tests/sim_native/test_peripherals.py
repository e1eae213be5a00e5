"""ADC and EEPROM: times and corners of the part."""

import pytest
from rig.avr import CLOCK_HZ
from rig.small import Small

from heatwright.sim.native.analog import millivolts

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
    assert adc["code"] == 512
    assert adc["cycles"] == pytest.approx(13 * 128, abs=40)


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


def test_channels_above_seven_of_the_2560() -> None:
    source = CONVERTER.replace("ADMUX", "ADCSRB = _BV(MUX5); ADMUX")
    adc = Small(source, mcu="atmega2560", seconds=0.001)
    adc.avr.adc.set(13, millivolts(789))
    adc["mux"] = AVCC | 5
    adc.avr.run(0.001)
    assert adc["code"] == 789


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
    assert writer["written"] == 0xFF
    assert writer.avr.eeprom.writing is None
    assert writer.avr.eeprom.contents[9:19] == b"\xff01234567\xff"
    assert (writer.avr.eeprom.writes, writer.avr.eeprom.violations) == (8, 0)


@PARTS
def test_the_ready_interrupt_comes_as_long_as_nothing_is_written(mcu: str) -> None:
    writer = Small(
        """
        #ifdef EEMPE
        #define MASTER EEMPE
        #define START EEPE
        #define READY EE_READY_vect
        #else
        #define MASTER EEMWE
        #define START EEWE
        #define READY EE_RDY_vect
        #endif
        volatile uint8_t next;
        ISR(READY) {
            if (next == 10) { EECR &= ~_BV(EERIE); return; }
            EEAR = E2END - 9 + next; EEDR = next; next++;
            EECR |= _BV(MASTER); EECR |= _BV(START);
        }
        int main(void) { EECR |= _BV(EERIE); sei(); for (;;) {} }""",
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
    assert program.avr.eeprom.contents[5:7] == b"\x77\xff"
    assert program.avr.eeprom.violations == 1
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
