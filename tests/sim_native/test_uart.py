"""UARTs on all chips: formats, parity, errors, flags, and a line that does anything."""

from functools import cache

import numpy as np
import pytest
from avr_firmware import CLOCK_HZ, compiled, powered

from heatwright.sim.avr import Avr, AvrError
from heatwright.sim.dwarf import Variables
from heatwright.sim.elf import Elf
from heatwright.sim.native.characters import Format, heard
from heatwright.sim.native.parts import PARTS

BAUD = 19_200
REGISTERS = """
#if defined(UCSR0C)
#define A_ UCSR0A
#define B_ UCSR0B
#define C_ UCSR0C
#define D_ UDR0
#define H_ UBRR0H
#define L_ UBRR0L
#elif defined(UCSR1C)
#define A_ UCSR1A
#define B_ UCSR1B
#define C_ UCSR1C
#define D_ UDR1
#define H_ UBRR1H
#define L_ UBRR1L
#else
#define A_ UCSRA
#define B_ UCSRB
#define C_ UCSRC
#define D_ UDR
#define H_ UBRRH
#define L_ UBRRL
#endif
#if defined(USART_RX_vect)
#define RX_ USART_RX_vect
#define TX_ USART_TX_vect
#define EMPTY_ USART_UDRE_vect
#elif defined(USART_RXC_vect)
#define RX_ USART_RXC_vect
#define TX_ USART_TXC_vect
#define EMPTY_ USART_UDRE_vect
#elif defined(USART0_RX_vect)
#define RX_ USART0_RX_vect
#define TX_ USART0_TX_vect
#define EMPTY_ USART0_UDRE_vect
#else
#define RX_ USART1_RX_vect
#define TX_ USART1_TX_vect
#define EMPTY_ USART1_UDRE_vect
#endif
#ifdef URSEL
#define SET_FORMAT(v) (C_ = (uint8_t)(0x80 | (v)))
#else
#define SET_FORMAT(v) (C_ = (v))
#endif
"""
LISTENER = """
volatile uint8_t n, values[200], flags[200], ninth[200];
ISR(RX_) {
    uint8_t status = A_, high = B_ & 2, value = D_;
    if (n < 200) { flags[n] = status & 0x1c; ninth[n] = high; values[n++] = value; }
}
int main(void) {
    H_ = 0; L_ = DIVISOR; SET_FORMAT(FORMAT);
    B_ = 0x90 | EXTRA; sei();
    for (;;) { WORK }
}
"""
FE, DOR, UPE = 0x10, 0x08, 0x04
FORMATS = [
    (Format(8, "none", 1), 0x06),
    (Format(8, "even", 1), 0x26),
    (Format(8, "odd", 1), 0x36),
    (Format(8, "none", 2), 0x0E),
    (Format(8, "even", 2), 0x2E),
    (Format(7, "even", 1), 0x24),
    (Format(7, "odd", 2), 0x3C),
    (Format(5, "none", 1), 0x00),
    (Format(6, "odd", 1), 0x32),
]
ALL = bytes(range(0, 256, 3)) + b"\xff\x00"
EVEN = Format(8, "even", 1)


@cache
def listener(mcu: str, code: int, work: str = "", divisor: int = 51, extra: int = 0) -> Elf:
    defines = [f"-DFORMAT={code}", f"-DWORK={work}", f"-DDIVISOR={divisor}", f"-DEXTRA={extra}"]
    return compiled(REGISTERS + LISTENER, *defines, mcu=mcu)


def listening(mcu: str, code: int, work: str = "", divisor: int = 51, extra: int = 0) -> Avr:
    avr = powered(listener(mcu, code, work, divisor, extra), mcu)
    avr.run(0.001)
    return avr


def number(mcu: str) -> int:
    return 1 if mcu == "atmega32u4" else 0


def array(avr: Avr, program: Elf, name: str) -> bytes:
    variables = Variables(program)
    count = avr.read_ram(variables["n"].address, 1)[0]
    return avr.read_ram(variables[name].address, count)


@pytest.mark.parametrize("mcu", PARTS)
@pytest.mark.parametrize(("form", "code"), FORMATS)
def test_every_format_arrives(mcu: str, form: Format, code: int) -> None:
    avr = listening(mcu, code)
    avr.uarts[number(mcu)].send(ALL, BAUD, form)
    avr.run(len(ALL) * form.bits / BAUD + 0.001)
    program = listener(mcu, code)
    mask = (1 << form.data_bits) - 1
    assert array(avr, program, "values") == bytes(value & mask for value in ALL)
    assert not any(array(avr, program, "flags"))


@pytest.mark.parametrize("mcu", PARTS)
@pytest.mark.parametrize("bit", range(11))
def test_a_turned_bit_is_seen_by_parity_or_stop(mcu: str, bit: int) -> None:
    """A start bit that is turned over makes a late start, or no character at all."""
    avr = listening(mcu, 0x26)
    avr.uarts[number(mcu)].send(b"\x0f\x5a", BAUD, EVEN, gap_s=0.002, flips=[1 << bit, 0])
    avr.run(0.01)
    program = listener(mcu, 0x26)
    values, flags = array(avr, program, "values"), array(avr, program, "flags")
    assert values[-1:] == b"\x5a"
    assert flags[-1] == 0
    if 1 <= bit <= 8:
        assert (values[0], flags[0]) == (0x0F ^ 1 << (bit - 1), UPE)
    elif bit == 9:
        assert (values[0], flags[0]) == (0x0F, UPE)
    elif bit == 10:
        assert (values[0], flags[0]) == (0x0F, FE)
    else:
        assert values[0] != 0x0F or len(values) == 1


@pytest.mark.parametrize(("sent", "code"), [("odd", 0x26), ("even", 0x36)])
def test_the_wrong_parity_is_seen_in_every_byte(sent: str, code: int) -> None:
    avr = listening("atmega32", code)
    avr.uarts[0].send(ALL, BAUD, Format(8, sent))  # type: ignore[arg-type]
    avr.run(0.1)
    assert set(array(avr, listener("atmega32", code), "flags")) == {UPE}


def test_no_parity_where_one_is_expected_breaks_the_stop_bit_or_the_parity() -> None:
    """Back to back the parity bit is taken from the stop bit, the stop bit from the next start."""
    avr = listening("atmega328p", 0x26)
    avr.uarts[0].send(b"\x01\x03\x03\x01", BAUD)
    avr.run(0.01)
    flags = array(avr, listener("atmega328p", 0x26), "flags")
    assert flags[0] == FE | 0
    assert UPE in [flag & UPE for flag in flags]


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize(("form", "code"), FORMATS)
def test_speeds_are_borne_as_far_as_the_part_bears_them(
    form: Format, code: int, double: bool
) -> None:
    """ATmega328P data sheet, 19.7.3: the slowest and the fastest speed that can be received."""
    d, s, first, middle = (
        form.data_bits + (form.parity != "none"),
        *((8, 4, 5) if double else (16, 8, 9)),
    )
    slow = (d + 1) * s / (s - 1 + d * s + first)
    fast = (d + 2) * s / ((d + 1) * s + middle)
    beyond = 0.5 / (d + 1)  # half a bit in a character
    form = Format(form.data_bits, form.parity)
    work = "A_ = 2;" if double else ""
    program = listener("atmega328p", code, work, 103 if double else 51)
    for ratio, arrives in [
        (slow, True),
        (fast, True),
        (slow - beyond, False),
        (fast + beyond, False),
    ]:
        avr = powered(program)
        avr.run(0.001)
        avr.uarts[0].send(ALL, CLOCK_HZ / 16 / 52 * (1 + (ratio - 1) * 0.999), form)
        avr.run(0.1)
        right = bytes(value & (1 << form.data_bits) - 1 for value in ALL)
        assert (array(avr, program, "values") == right) is arrives
        assert (not any(array(avr, program, "flags"))) is arrives


@pytest.mark.parametrize("baud", [9600, 38_400, 22_000, 17_000])
def test_another_speed_gives_errors(baud: int) -> None:
    avr = listening("atmega16", 0x26)
    avr.uarts[0].send(ALL, baud, EVEN)
    avr.run(0.2)
    program = listener("atmega16", 0x26)
    assert array(avr, program, "values") != ALL
    assert any(array(avr, program, "flags"))


def test_a_character_without_an_edge_stays_unheard() -> None:
    """Its start bit follows a low stop bit; what is sent later does not bring it back."""
    avr = listening("atmega16", 0x36)
    form = Format(8, "odd")
    avr.uarts[0].send(b"\x5d\xfc", BAUD, form, flips=[1 << 10, 0])
    avr.run(0.005)
    avr.uarts[0].send(b"\x11", BAUD, form)
    avr.run(0.005)
    program = listener("atmega16", 0x36)
    assert array(avr, program, "values") == b"\x5d\x11"
    assert list(array(avr, program, "flags")) == [FE, 0]


def test_a_break_is_one_zero_without_stop_bit() -> None:
    avr = listening("atmega32", 0x26)
    avr.uarts[0].send_break(0.01)
    avr.uarts[0].send(b"A", BAUD, EVEN, gap_s=0.001)
    avr.run(0.02)
    program = listener("atmega32", 0x26)
    assert array(avr, program, "values") == b"\x00A"
    assert list(array(avr, program, "flags")) == [FE, 0]


@pytest.mark.parametrize("mcu", PARTS)
def test_an_overrun_is_told_with_the_next_byte_read(mcu: str) -> None:
    work = "cli(); _delay_ms(5); sei(); _delay_ms(5);"
    avr = powered(listener(mcu, 0x06, work), mcu)
    avr.run(0.0005)
    avr.uarts[number(mcu)].send(bytes(range(1, 7)), BAUD)
    avr.run(0.02)
    program = listener(mcu, 0x06, work)
    assert array(avr, program, "values")[:3] == bytes([1, 2, 3])
    assert list(array(avr, program, "flags")) == [DOR, 0, 0]


def test_gaps_are_kept() -> None:
    """The time of each interrupt, by its own log: to within a sample and the interrupt's entry."""
    source = (
        REGISTERS
        + """
    ISR(RX_) { (void)D_; PORTB ^= 1; }
    int main(void) { DDRB = 1; H_ = 0; L_ = 51; B_ = 0x90; sei(); for (;;) {} }
    """
    )
    avr = powered(compiled(source, mcu="atmega32"), "atmega32")
    avr.pins.watch("PB0")
    avr.run(0.001)
    avr.pins.take()
    gaps = [0.0, 0.003, 0.0, 0.001]
    avr.uarts[0].send(b"abcd", BAUD, gap_s=gaps)
    avr.run(0.02)
    times = avr.pins.take()["cycle"] / CLOCK_HZ
    expected = np.array(gaps[1:]) + 10 / BAUD
    np.testing.assert_allclose(np.diff(times), expected, rtol=0, atol=52 / CLOCK_HZ + 20 / CLOCK_HZ)


@pytest.mark.parametrize("mcu", PARTS)
@pytest.mark.parametrize(("form", "code"), FORMATS)
def test_every_format_is_sent(mcu: str, form: Format, code: int) -> None:
    source = (
        REGISTERS
        + f"""
    ISR(EMPTY_) {{ static uint8_t c; D_ = c; c = (uint8_t)(c + 5); if (!c) B_ &= (uint8_t)~0x20; }}
    int main(void) {{ SET_FORMAT({code}); H_ = 0; L_ = 51; B_ = 0x28; sei(); for (;;) {{}} }}
    """
    )
    avr = powered(compiled(source, mcu=mcu), mcu)
    avr.run(0.2)
    sent = avr.uarts.take()
    assert {Format.of(int(each)) for each in sent["format"]} == {form}
    assert set(np.diff(sent["end"].astype(int))) == {form.bits * 16 * 52}
    assert set(sent["bit_cycles"]) == {16 * 52}
    bit = CLOCK_HZ / BAUD
    mask = (1 << form.data_bits) - 1
    assert [heard(each, form, bit) for each in sent] == [
        (value & mask, True) for value in sent["value"].tolist()
    ]


def test_what_is_sent_in_another_format_is_heard_wrong() -> None:
    source = (
        REGISTERS
        + """
    int main(void) { SET_FORMAT(0x36); L_ = 51; B_ = 8; D_ = 0x55; for (;;) {} }
    """
    )
    avr = powered(compiled(source))
    avr.run(0.01)
    sent = avr.uarts.take()
    bit = CLOCK_HZ / BAUD
    assert heard(sent[0], Format(8, "odd"), bit) == (0x55, True)
    assert heard(sent[0], EVEN, bit) == (0x55, False)
    assert heard(sent[0], Format(8, "odd"), bit / 2)[1] is False


@pytest.mark.parametrize("mcu", PARTS)
def test_the_end_of_the_last_byte_is_told_once(mcu: str) -> None:
    """TXC comes when buffer and shift register are empty; its interrupt clears it."""
    source = (
        REGISTERS
        + """
    volatile uint8_t n, values[8];
    ISR(TX_) { values[n++] = A_ & 0x40; PORTB |= 1; if (n == 1) { D_ = 3; } }
    int main(void) {
        DDRB = 1; H_ = 0; L_ = 51; SET_FORMAT(0x26); B_ = 0x48; sei();
        D_ = 1; D_ = 2; for (;;) {}
    }
    """
    )
    program = compiled(source, mcu=mcu)
    avr = powered(program, mcu)
    avr.pins.watch("PB0")
    avr.run(0.01)
    assert array(avr, program, "values") == b"\0\0"
    ends = avr.uarts.take()["end"].astype(int)
    rise = int(avr.pins.take()["cycle"][-1])
    assert 0 <= rise - ends[1] < 60
    assert len(ends) == 3


def test_the_flag_of_the_end_is_cleared_by_writing_it() -> None:
    source = (
        REGISTERS
        + """
    volatile uint8_t n = 4, values[4];
    int main(void) {
        L_ = 51; B_ = 8; D_ = 1;
        values[0] = A_; _delay_ms(2); values[1] = A_; A_ = 0; values[2] = A_; A_ = 0x40;
        values[3] = A_; for (;;) {}
    }
    """
    )
    program = compiled(source)
    avr = powered(program)
    avr.run(0.01)
    assert [value & 0x60 for value in array(avr, program, "values")] == [0x20, 0x60, 0x60, 0x20]


def test_an_interrupt_that_does_not_read_comes_again() -> None:
    """The flag stays, so the interrupt is entered after one instruction of the program."""
    source = (
        REGISTERS
        + """
    volatile uint8_t n, values[200];
    ISR(RX_) { if (++n == 100) values[99] = D_; }
    int main(void) { L_ = 51; B_ = 0x90; sei(); for (;;) {} }
    """
    )
    program = compiled(source)
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(b"x", BAUD)
    avr.run(0.01)
    assert array(avr, program, "values")[99:] == b"x"


def test_an_enabled_interrupt_comes_for_what_has_already_happened() -> None:
    source = (
        REGISTERS
        + """
    volatile uint8_t n, values[8];
    ISR(RX_) { values[n++] = D_; }
    int main(void) { L_ = 51; B_ = 0x10; sei(); _delay_ms(5); B_ |= 0x80; for (;;) {} }
    """
    )
    program = compiled(source)
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(b"xy", BAUD)
    avr.run(0.003)
    assert array(avr, program, "values") == b""
    avr.run(0.003)
    assert array(avr, program, "values") == b"xy"


def test_a_receiver_switched_off_forgets() -> None:
    source = (
        REGISTERS
        + """
    volatile uint8_t n, values[8];
    int main(void) {
        L_ = 51; B_ = 0x10; _delay_ms(5); B_ = 0; B_ = 0x10;
        for (;;) if (A_ & 0x80) values[n++] = D_;
    }
    """
    )
    program = compiled(source)
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(b"xy", BAUD)
    avr.run(0.006)
    avr.uarts[0].send(b"z", BAUD)
    avr.run(0.003)
    assert array(avr, program, "values") == b"z"


def test_a_receiver_switched_on_within_a_character_takes_its_next_edge_for_a_start() -> None:
    source = (
        REGISTERS
        + """
    volatile uint8_t n, values[8], flags[8];
    int main(void) {
        L_ = 51; SET_FORMAT(0x26); _delay_us(1160); B_ = 0x10;
        for (;;) if (A_ & 0x80) { flags[n] = A_ & 0x1c; values[n++] = D_; }
    }
    """
    )
    program = compiled(source)
    avr = powered(program)
    avr.run(0.001)
    avr.uarts[0].send(b"\x55" * 3, BAUD, EVEN)
    avr.run(0.01)
    assert array(avr, program, "values") != b"\x55" * 3


def test_the_shared_register_reads_format_only_twice_in_a_row() -> None:
    source = """
    volatile uint8_t n = 3, values[3];
    int main(void) {
        uint8_t a, b;
        UBRRH = 1; UCSRC = _BV(URSEL) | 0x26;
        values[0] = UBRRH;
        asm volatile("in %0, %2\\n in %1, %2" : "=r"(a), "=r"(b) : "I"(_SFR_IO_ADDR(UBRRH)));
        values[1] = a; values[2] = b;
        for (;;) {}
    }
    """
    program = compiled(source, mcu="atmega32")
    avr = powered(program, "atmega32")
    avr.run(0.001)
    assert array(avr, program, "values") == bytes([1, 1, 0xA6])


def test_nine_bits_go_both_ways() -> None:
    avr = listening("atmega328p", 0x06, "", 51, 0x04)
    form = Format(9, "none", 1)
    avr.uarts[0].send(b"\x12\x34", BAUD, form, flips=[1 << 9, 0])
    avr.run(0.01)
    program = listener("atmega328p", 0x06, "", 51, 0x04)
    assert array(avr, program, "values") == b"\x12\x34"
    assert list(array(avr, program, "ninth")) == [2, 0]


def test_a_reset_ends_what_is_received() -> None:
    avr = listening("atmega32", 0x26)
    avr.uarts[0].send(b"abc", BAUD, EVEN)
    avr.run(0.0009)
    avr.reset()
    avr.run(0.01)
    program = listener("atmega32", 0x26)
    assert array(avr, program, "values")[-1:] == b"c"


@pytest.mark.parametrize("setting", ["UCSR0C = 0x46;", "UCSR0A = 1;"])
def test_what_is_not_simulated_ends_the_run(setting: str) -> None:
    avr = powered(compiled(f"int main(void) {{ {setting} for (;;) {{}} }}"))
    with pytest.raises(AvrError, match="not simulated"):
        avr.run(0.001)
