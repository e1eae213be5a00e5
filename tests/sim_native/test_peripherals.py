"""UART, ADC and EEPROM: times and corners of the part."""

import numpy as np
import pytest
from avr_firmware import CLOCK_HZ, compiled, powered, running

from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.native.analog import millivolts

SENDER = """
static const char text[] PROGMEM = "$49.87 50.00;\\n";
static volatile uint8_t at;
ISR(USART_UDRE_vect) {
    char c = pgm_read_byte(&text[at]);
    if (c) { UDR0 = c; at++; } else UCSR0B &= ~_BV(UDRIE0);
}
"""
FORMATS = {
    "8N1": ("UCSR0C = 0x06;", 10),
    "8E1": ("UCSR0C = 0x26;", 11),
    "8N2": ("UCSR0C = 0x0e;", 11),
    "7O2": ("UCSR0C = 0x3c;", 11),
}


@pytest.mark.parametrize("frame", FORMATS)
@pytest.mark.parametrize("order", ["before", "after"])
def test_bytes_leave_at_the_lines_speed(frame: str, order: str) -> None:
    """simavr takes 11 bits for 8N1 and looks at the format only when UBRR is written."""
    setting, bits = FORMATS[frame]
    before, after = (setting, "") if order == "before" else ("", setting)
    avr = running(
        f"""{SENDER} int main(void) {{
            {before} UBRR0 = 103; {after} UCSR0B = _BV(TXEN0) | _BV(UDRIE0); sei(); for (;;) {{}}
        }}"""
    )
    avr.run(0.05)
    sent = avr.uarts.take()
    assert bytes(sent["value"]) == b"$49.87 50.00;\n"
    assert set(np.diff(sent["end"].astype(int))) == {bits * 16 * 104}
    assert avr.uarts[0].frame_s == bits * 16 * 104 / CLOCK_HZ
    assert avr.uarts[0].overruns == 0


def test_an_old_uart_whose_registers_share_an_address() -> None:
    avr = running(
        """int main(void) {
            UBRRH = 1; UCSRC = _BV(URSEL) | _BV(UPM1) | 0x06; UBRRL = 0x9f; UCSRB = _BV(TXEN);
            for (char c = 'a';; c++) { while (!(UCSRA & _BV(UDRE))) {} UDR = c; }
        }""",
        mcu="atmega32",
    )
    avr.run(0.05)
    sent = avr.uarts.take()
    assert bytes(sent["value"])[:3] == b"abc"
    assert set(np.diff(sent["end"].astype(int))) == {11 * 16 * 0x1A0}


def test_bytes_written_to_a_full_transmitter_are_lost() -> None:
    avr = running(
        """int main(void) {
            UBRR0 = 103; UCSR0B = _BV(TXEN0);
            for (char c = 'a'; c < 'f'; c++) UDR0 = c;
            for (;;) {}
        }"""
    )
    avr.run(0.05)
    sent = avr.uarts.take()
    assert bytes(sent["value"][~sent["lost"]]) == b"ab"
    assert avr.uarts[0].overruns == 3


ECHO = """
volatile uint8_t got[64], n, overruns;
ISR(USART_RX_vect) {
    if (UCSR0A & _BV(DOR0)) overruns++;
    uint8_t c = UDR0;
    if (n < 64) got[n++] = c;
}
int main(void) {
    UBRR0 = 16; UCSR0A = _BV(U2X0); UCSR0B = _BV(RXEN0) | _BV(RXCIE0);
    WORK
}
"""


def received(avr: Avr, program: object) -> bytes:
    variables = Variables(program)  # type: ignore[arg-type]
    count = avr.read_ram(variables["n"].address, 1)[0]
    return avr.read_ram(variables["got"].address, count)


def test_bytes_arrive_at_the_lines_speed() -> None:
    program = compiled(ECHO, "-DWORK=sei(); for (;;) {}")
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(b"M104 S200\n", 115_200)
    avr.run(0.0004)
    assert received(avr, program) == b"M104"[: len(received(avr, program))]
    assert 3 <= len(received(avr, program)) <= 4
    avr.run(0.002)
    assert received(avr, program) == b"M104 S200\n"
    assert avr.uarts[0].unsent == 0


def test_a_deaf_receiver_loses_what_the_part_would_lose() -> None:
    """Two bytes are buffered, a third is in the shift register; simavr would keep 63."""
    program = compiled(ECHO, "-DWORK=cli(); _delay_ms(5); sei(); for (;;) {}")
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(bytes(range(40)), 115_200)
    avr.run(0.02)
    assert received(avr, program) == bytes([0, 1, 2])


def test_a_flood_on_a_receiver_that_is_off_does_nothing() -> None:
    avr = running("int main(void) { UCSR0B = _BV(TXEN0); DDRB = 1; for (;;) PINB = 1; }")
    avr.uarts[0].send(bytes(5000), 115_200)
    avr.run(0.2)
    assert avr.uarts[0].unsent < 5000 - 0.19 * 11_520
    avr.uarts[0].unsend()
    assert avr.uarts[0].unsent == 0


CONVERTER = """
volatile uint16_t code; volatile uint16_t cycles;
int main(void) {
    ADMUX = _BV(REFS0) | CHANNEL;
    ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
    TCCR1B = _BV(CS10);
    for (;;) {
        TCNT1 = 0;
        ADCSRA |= _BV(ADSC);
        while (ADCSRA & _BV(ADSC)) {}
        cycles = TCNT1;
        code = ADC;
    }
}
"""


@pytest.mark.parametrize("code", [0, 1, 131, 511, 512, 1022, 1023])
def test_each_code_has_its_voltages(code: int) -> None:
    """code = floor(1024 V / Vref): the whole width of a code gives that code (data sheet)."""
    program = compiled(CONVERTER, "-DCHANNEL=3")
    avr = powered(program)
    address = Variables(program)["code"].address
    width = 5000 / 1024
    for place in (0.001, 0.5, 0.999):
        avr.adc.set(3, (code + place) * width)
        avr.run(0.001)
        assert int.from_bytes(avr.read_ram(address, 2), "little") == code
    assert (code + 0.5) * width == millivolts(code)


def test_voltages_beyond_the_supply_are_clipped() -> None:
    program = compiled(CONVERTER, "-DCHANNEL=0")
    avr = powered(program)
    for voltage_mv, code in ((5001, 1023), (12_000, 1023), (-50, 0)):
        avr.adc.set(0, voltage_mv)
        avr.run(0.001)
        assert int.from_bytes(avr.read_ram(Variables(program)["code"].address, 2), "little") == code


def test_a_conversion_takes_thirteen_clocks() -> None:
    program = compiled(CONVERTER, "-DCHANNEL=0")
    avr = powered(program)
    avr.run(0.01)
    cycles = int.from_bytes(avr.read_ram(Variables(program)["cycles"].address, 2), "little")
    assert cycles == pytest.approx(13 * 128, abs=12)
    assert avr.adc.conversions == pytest.approx(0.01 * CLOCK_HZ / (13 * 128), abs=8)


def test_the_voltage_is_taken_when_the_conversion_starts() -> None:
    program = compiled(
        """volatile uint16_t code;
        int main(void) {
            ADMUX = _BV(REFS0); ADCSRA = 0x87; ADCSRA |= _BV(ADSC); _delay_ms(1);
            ADMUX |= 1; code = ADC; for (;;) {}
        }"""
    )
    avr = powered(program)
    avr.adc.set(0, millivolts(300))
    avr.adc.set(1, millivolts(700))
    avr.run(0.0005)
    avr.adc.set(0, millivolts(900))
    avr.run(0.01)
    assert int.from_bytes(avr.read_ram(Variables(program)["code"].address, 2), "little") == 300


def test_left_adjusted_results_need_the_high_byte_only() -> None:
    program = compiled(
        """volatile uint8_t high;
        int main(void) {
            ADMUX = _BV(REFS0) | _BV(ADLAR); ADCSRA = 0x87;
            for (;;) { ADCSRA |= _BV(ADSC); while (ADCSRA & _BV(ADSC)) {} high = ADCH; }
        }"""
    )
    avr = powered(program)
    for code in (0, 400, 1023):
        avr.adc.set(0, millivolts(code))
        avr.run(0.001)
        assert avr.read_ram(Variables(program)["high"].address, 1)[0] == code >> 2


def test_channels_above_seven_of_the_2560() -> None:
    program = compiled(
        """volatile uint16_t code;
        int main(void) {
            ADMUX = _BV(REFS0) | 5; ADCSRB = _BV(MUX5); ADCSRA = 0x87;
            for (;;) { ADCSRA |= _BV(ADSC); while (ADCSRA & _BV(ADSC)) {} code = ADC; }
        }""",
        mcu="atmega2560",
    )
    avr = powered(program, "atmega2560")
    avr.adc.set(13, millivolts(789))
    avr.run(0.001)
    assert int.from_bytes(avr.read_ram(Variables(program)["code"].address, 2), "little") == 789


WRITER = """
volatile uint8_t written;
int main(void) {
    for (uint8_t i = 0; i < 8; i++) { eeprom_write_byte((uint8_t *)(10 + i), 0x30 + i); written++; }
    eeprom_busy_wait();
    written = 0xff;
    for (;;) {}
}
"""


def test_an_eeprom_byte_takes_its_time() -> None:
    program = compiled(WRITER)
    avr = powered(program)
    written = Variables(program)["written"].address
    for count in range(1, 9):
        avr.run(0.0033)
        assert avr.read_ram(written, 1)[0] in {count, count + 1, 0xFF}
        assert avr.read_ram(written, 1)[0] != 0xFF
    avr.run(0.001)
    assert avr.read_ram(written, 1)[0] == 0xFF
    assert avr.eeprom.contents[9:19] == b"\xff01234567\xff"
    assert (avr.eeprom.writes, avr.eeprom.violations) == (8, 0)


def test_an_old_eeprom_takes_longer() -> None:
    avr = running(
        "int main(void) { eeprom_write_byte((uint8_t *)3, 7); for (;;) {} }", mcu="atmega32"
    )
    avr.run(0.0083)
    assert avr.eeprom.writing is not None
    avr.run(0.0003)
    assert avr.eeprom.writing is None
    assert avr.eeprom.contents[3] == 7


def test_a_power_cut_leaves_the_byte_undefined_and_the_rest_as_it_was() -> None:
    avr = running(WRITER)
    avr.eeprom.contents = bytes([1]) * 1024
    avr.run(0.0033 * 2.5)
    writing = avr.eeprom.writing
    assert writing is not None
    assert (writing.address, writing.old, writing.new) == (12, 1, 0x32)
    for undefined in (0, 0x55, 0xFF):
        left = avr.eeprom.after_power_cut(undefined)
        assert left[10:14] == bytes([0x30, 0x31, undefined, 1])
        assert left[:10] + left[14:] == bytes([1]) * 1020


def test_access_during_a_write_is_ignored_and_counted() -> None:
    avr = running(
        """int main(void) {
            EEAR = 5; EEDR = 0x77; EECR = _BV(EEMPE); EECR = _BV(EEMPE) | _BV(EEPE);
            EEAR = 6; EEDR = 0x11; EECR |= _BV(EERE); PORTB = EEDR;
            for (;;) {}
        }"""
    )
    avr.run(0.01)
    assert avr.eeprom.contents[5:7] == b"\x77\xff"
    assert avr.eeprom.violations == 1
    assert avr.read_ram(0x25, 1) == b"\x11"


@pytest.mark.parametrize(("mode", "result"), [(0, 0x0F), (1, 0xFF), (2, 0x05)])
def test_eeprom_programming_modes(mode: int, result: int) -> None:
    avr = running(
        f"""int main(void) {{
            EEAR = 5; EEDR = 0x0f; EECR = _BV(EEMPE) | {mode} << 4;
            EECR |= _BV(EEPE); for (;;) {{}}
        }}"""
    )
    avr.eeprom.contents = bytes([0x55]) * 1024
    avr.run(0.01)
    assert avr.eeprom.contents[5] == result


def test_the_ready_interrupt_comes_as_long_as_nothing_is_written() -> None:
    program = compiled(
        """volatile uint8_t next;
        ISR(EE_READY_vect) {
            if (next == 10) { EECR &= ~_BV(EERIE); return; }
            EEAR = next; EEDR = next; next++;
            EECR |= _BV(EEMPE); EECR |= _BV(EEPE);
        }
        int main(void) { EECR |= _BV(EERIE); sei(); for (;;) {} }"""
    )
    avr = powered(program)
    avr.run(0.0033 * 9.5)
    assert avr.read_ram(Variables(program)["next"].address, 1)[0] == 10
    avr.run(0.01)
    assert avr.eeprom.contents[:11] == bytes(range(10)) + b"\xff"
    assert avr.eeprom.violations == 0


def test_a_write_ends_through_a_reset() -> None:
    avr = running("int main(void) { eeprom_write_byte((uint8_t *)3, 7); for (;;) {} }")
    avr.run(0.001)
    avr.reset()
    assert avr.eeprom.writing is not None
    assert avr.eeprom.contents[3] == 7


def test_a_program_brings_its_eeprom() -> None:
    avr = running(
        "uint8_t kept[3] EEMEM = {1, 2, 3}; int main(void) { return eeprom_read_byte(kept); }"
    )
    assert avr.eeprom.contents[:4] == b"\x01\x02\x03\xff"


def test_too_large_an_eeprom_image() -> None:
    with pytest.raises(ValueError, match="1024 bytes, not 1025"):
        running("int main(void) { for (;;) {} }").eeprom.contents = bytes(1025)
