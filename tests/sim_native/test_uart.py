"""UARTs on all chips: formats, parity, errors, flags, and a line that does anything."""

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, Small

from heatwright.sim.native.characters import Format, heard
from heatwright.sim.native.parts import PARTS

BAUD = 19_200
VARIABLES = """
#ifdef URSEL
#define SET_FORMAT(v) (C_ = (uint8_t)(0x80 | (v)))
#else
#define SET_FORMAT(v) (C_ = (v))
#endif
volatile uint8_t n, values[200], flags[200], ninth[200];
"""
LISTENER = """
ISR(RX_VECTOR) {
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
EVEN, ODD = Format(8, "even", 1), Format(8, "odd", 1)
FORMATS = [
    (Format(8, "none", 1), 0x06), (EVEN, 0x26), (ODD, 0x36), (Format(8, "none", 2), 0x0E),
    (Format(8, "even", 2), 0x2E), (Format(7, "even", 1), 0x24), (Format(7, "odd", 2), 0x3C),
    (Format(5, "none", 1), 0x00), (Format(6, "odd", 1), 0x32),
]  # fmt: skip
ALL = bytes(range(0, 256, 3)) + b"\xff\x00"
every_part = pytest.mark.parametrize("mcu", PARTS)
every_format = pytest.mark.parametrize(("form", "code"), FORMATS)


def names(mcu: str) -> list[str]:
    old = mcu in {"atmega16", "atmega32"}
    number = "" if old else "1" if mcu == "atmega32u4" else "0"
    usart = "USART" if old or mcu == "atmega328p" else f"USART{number}"
    registers = {"D": f"UDR{number}", "H": f"UBRR{number}H", "L": f"UBRR{number}L"}
    registers |= {letter: f"UCSR{number}{letter}" for letter in "ABC"}
    vectors = {"UDRE": "UDRE", "RX": "RXC" if old else "RX", "TX": "TXC" if old else "TX"}
    return [
        *(f"-D{name}_={register}" for name, register in registers.items()),
        *(f"-D{name}_VECTOR={usart}_{vector}_vect" for name, vector in vectors.items()),
    ]


class Uart(Small):
    def __init__(self, source: str, *flags: str, mcu: str = "atmega328p") -> None:
        super().__init__(VARIABLES + source, *flags, *names(mcu), mcu=mcu)
        self.line = self.avr.uarts[1 if mcu == "atmega32u4" else 0]

    def heard(self, name: str = "values") -> bytes:
        return bytes(self[name][: self["n"]])


def listening(mcu: str, code: int, work: str = "", divisor: int = 51, *, extra: int = 0) -> Uart:
    defines = [f"-DFORMAT={code}", f"-DWORK={work}", f"-DDIVISOR={divisor}", f"-DEXTRA={extra}"]
    found = Uart(LISTENER, *defines, mcu=mcu)
    found.avr.run(0.001)
    return found


@every_part
@every_format
def test_every_format_arrives(mcu: str, form: Format, code: int) -> None:
    uart = listening(mcu, code)
    uart.line.send(ALL, BAUD, form)
    uart.avr.run(len(ALL) * form.bits / BAUD + 0.001)
    mask = (1 << form.data_bits) - 1
    assert uart.heard() == bytes(value & mask for value in ALL)
    assert not any(uart.heard("flags"))


@every_part
@pytest.mark.parametrize("bit", range(11))
def test_a_turned_bit_is_seen_by_parity_or_stop(mcu: str, bit: int) -> None:
    """A start bit that is turned over makes a late start, or no character at all."""
    uart = listening(mcu, 0x26)
    uart.line.send(b"\x0f\x5a", BAUD, EVEN, gap_s=0.002, flips=[1 << bit, 0])
    uart.avr.run(0.01)
    values, flags = uart.heard(), uart.heard("flags")
    assert (values[-1:], flags[-1]) == (b"\x5a", 0)
    if bit == 0:
        assert values[0] != 0x0F or len(values) == 1
    else:
        turned = 0x0F ^ 1 << (bit - 1) if bit <= 8 else 0x0F
        assert (values[0], flags[0]) == (turned, FE if bit == 10 else UPE)


@pytest.mark.parametrize("double", [False, True])
@every_format
def test_speeds_are_borne_as_far_as_the_part_bears_them(
    form: Format, code: int, double: bool
) -> None:
    """ATmega328P data sheet, 19.7.3: the slowest and the fastest speed that can be received."""
    d = form.data_bits + (form.parity != "none")
    s, first, middle = (8, 4, 5) if double else (16, 8, 9)
    slow = (d + 1) * s / (s - 1 + d * s + first)
    fast = (d + 2) * s / ((d + 1) * s + middle)
    beyond = 0.5 / (d + 1)  # half a bit in a character
    right = bytes(value & (1 << form.data_bits) - 1 for value in ALL)
    for ratio, arrives in (
        (slow, True),
        (fast, True),
        (slow - beyond, False),
        (fast + beyond, False),
    ):
        work, divisor = ("A_ = 2;", 103) if double else ("", 51)
        uart = listening("atmega328p", code, work, divisor)
        speed = CLOCK_HZ / 16 / 52 * (1 + (ratio - 1) * 0.999)
        uart.line.send(ALL, speed, Format(form.data_bits, form.parity))
        uart.avr.run(0.1)
        assert (uart.heard() == right, not any(uart.heard("flags"))) == (arrives, arrives)


def test_a_character_without_an_edge_stays_unheard() -> None:
    """Its start bit follows a low stop bit; what is sent later does not bring it back."""
    uart = listening("atmega16", 0x36)
    uart.line.send(b"\x5d\xfc", BAUD, ODD, flips=[1 << 10, 0])
    uart.avr.run(0.005)
    uart.line.send(b"\x11", BAUD, ODD)
    uart.avr.run(0.005)
    assert (uart.heard(), list(uart.heard("flags"))) == (b"\x5d\x11", [FE, 0])


def test_a_break_is_one_zero_without_stop_bit() -> None:
    uart = listening("atmega32", 0x26)
    uart.line.send_break(0.01)
    uart.line.send(b"A", BAUD, EVEN, gap_s=0.001)
    uart.avr.run(0.02)
    assert (uart.heard(), list(uart.heard("flags"))) == (b"\x00A", [FE, 0])


@every_part
def test_an_overrun_is_told_with_the_next_byte_read(mcu: str) -> None:
    """Two bytes are buffered, a third is in the shift register; simavr would keep 63."""
    uart = listening(mcu, 0x06, "cli(); _delay_ms(5); sei(); _delay_ms(5);")
    uart.line.send(bytes(range(1, 7)), BAUD)
    uart.avr.run(0.02)
    assert (uart.heard(), list(uart.heard("flags"))) == (bytes([1, 2, 3]), [DOR, 0, 0])


def test_a_flood_on_a_receiver_that_is_off_does_nothing() -> None:
    uart = Uart("int main(void) { UCSR0B = _BV(TXEN0); DDRB = 1; for (;;) PINB = 1; }")
    uart.line.send(bytes(5000), 115_200)
    uart.avr.run(0.2)
    assert uart.line.unsent < 5000 - 0.19 * 11_520
    uart.line.unsend()
    assert uart.line.unsent == 0


def test_gaps_are_kept() -> None:
    """The time of each interrupt, by its own log: to within a sample and the interrupt's entry."""
    source = """ISR(RX_VECTOR) { (void)D_; PORTB ^= 1; }
    int main(void) { DDRB = 1; H_ = 0; L_ = 51; B_ = 0x90; sei(); for (;;) {} }"""
    uart = Uart(source, mcu="atmega32")
    uart.avr.pins.watch("PB0")
    uart.avr.run(0.001)
    uart.avr.pins.take()
    gaps = [0.0, 0.003, 0.0, 0.001]
    uart.line.send(b"abcd", BAUD, gap_s=gaps)
    uart.avr.run(0.02)
    assert uart.line.unsent == 0
    times = uart.avr.pins.take()["cycle"] / CLOCK_HZ
    expected = np.array(gaps[1:]) + 10 / BAUD
    np.testing.assert_allclose(np.diff(times), expected, rtol=0, atol=52 / CLOCK_HZ + 20 / CLOCK_HZ)


@every_part
@every_format
def test_every_format_is_sent(mcu: str, form: Format, code: int) -> None:
    """simavr takes 11 bits for 8N1, and looks at the format only when UBRR is written: before."""
    uart = Uart(
        f"""ISR(UDRE_VECTOR) {{
            static uint8_t c; D_ = c; c = (uint8_t)(c + 5); if (!c) B_ &= (uint8_t)~0x20;
        }}
        int main(void) {{ H_ = 0; L_ = 51; SET_FORMAT({code}); B_ = 0x28; sei(); for (;;) {{}} }}
        """,
        mcu=mcu,
    )
    uart.avr.run(0.2)
    sent = uart.avr.uarts.take()
    assert {Format.of(int(each)) for each in sent["format"]} == {form}
    assert set(np.diff(sent["end"].astype(int))) == {form.bits * 16 * 52}
    assert set(sent["bit_cycles"]) == {16 * 52}
    assert (uart.line.frame_s, uart.line.overruns) == (form.bits * 16 * 52 / CLOCK_HZ, 0)
    mask = (1 << form.data_bits) - 1
    due = [(value & mask, True) for value in sent["value"].tolist()]
    assert [heard(each, form, CLOCK_HZ / BAUD) for each in sent] == due


def test_bytes_written_to_a_full_transmitter_are_lost() -> None:
    uart = Uart("""int main(void) {
        UBRR0 = 103; B_ = _BV(TXEN0); for (char c = 'a'; c < 'f'; c++) D_ = c; for (;;) {}
    }""")
    uart.avr.run(0.05)
    sent = uart.avr.uarts.take()
    assert bytes(sent["value"][~sent["lost"]]) == b"ab"
    assert uart.line.overruns == 3


def test_what_is_sent_in_another_format_is_heard_wrong() -> None:
    uart = Uart("int main(void) { SET_FORMAT(0x36); L_ = 51; B_ = 8; D_ = 0x55; for (;;) {} }")
    uart.avr.run(0.01)
    (sent,) = uart.avr.uarts.take()
    bit = CLOCK_HZ / BAUD
    assert (heard(sent, ODD, bit), heard(sent, EVEN, bit)) == ((0x55, True), (0x55, False))
    assert heard(sent, ODD, bit / 2)[1] is False


@every_part
def test_the_end_of_the_last_byte_is_told_once(mcu: str) -> None:
    """TXC comes when buffer and shift register are empty; its interrupt clears it."""
    uart = Uart(
        """ISR(TX_VECTOR) { values[n++] = A_ & 0x40; PORTB |= 1; if (n == 1) { D_ = 3; } }
        int main(void) {
            DDRB = 1; H_ = 0; L_ = 51; SET_FORMAT(0x26); B_ = 0x48; sei();
            D_ = 1; D_ = 2; for (;;) {}
        }""",
        mcu=mcu,
    )
    uart.avr.pins.watch("PB0")
    uart.avr.run(0.01)
    assert uart.heard() == b"\0\0"
    ends = uart.avr.uarts.take()["end"].astype(int)
    assert 0 <= int(uart.avr.pins.take()["cycle"][-1]) - ends[1] < 60
    assert len(ends) == 3


POLLED = "for (;;) if (A_ & 0x80) values[n++] = D_;"
COURSES = {
    # A program; what is sent so many milliseconds after power-on, and what it has heard then.
    # The flag stays, so the interrupt is entered after one instruction of the program.
    "an interrupt that does not read comes again": (
        """ISR(RX_VECTOR) { if (++n >= 100) values[n - 100] = D_; }
        int main(void) { L_ = 51; B_ = 0x90; sei(); for (;;) {} }""",
        [(1, b"x", b""), (10, b"", b"x".ljust(100, b"\0"))],
    ),
    "an enabled interrupt comes for what has already happened": (
        """ISR(RX_VECTOR) { values[n++] = D_; }
        int main(void) { L_ = 51; B_ = 0x10; sei(); _delay_ms(5); B_ |= 0x80; for (;;) {} }""",
        [(1, b"xy", b""), (4, b"", b""), (7, b"", b"xy")],
    ),
    "a receiver switched off forgets": (
        f"int main(void) {{ L_ = 51; B_ = 0x10; _delay_ms(5); B_ = 0; B_ = 0x10; {POLLED} }}",
        [(1, b"xy", b""), (7, b"z", b""), (10, b"", b"z")],
    ),
    "the flag of the end is cleared by writing it": (
        """int main(void) {
            L_ = 51; B_ = 8; D_ = 1; n = 4; values[0] = A_ & 0x60; _delay_ms(2);
            values[1] = A_ & 0x60; A_ = 0; values[2] = A_ & 0x60; A_ = 0x40;
            values[3] = A_ & 0x60; for (;;) {}
        }""",
        [(10, b"", b"\x20\x60\x60\x20")],
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", COURSES)
def test_what_is_heard_and_when(what: str) -> None:
    source, deeds = COURSES[what]
    uart = Uart(source)
    for at_ms, sent, heard_by_then in deeds:
        uart.avr.run_to(at_ms * CLOCK_HZ // 1000)
        assert uart.heard() == heard_by_then
        uart.line.send(sent, BAUD)


def test_a_receiver_switched_on_within_a_character_takes_its_next_edge_for_a_start() -> None:
    start = "L_ = 51; SET_FORMAT(0x26); _delay_us(1160); B_ = 0x10;"
    uart = Uart(f"int main(void) {{ {start} {POLLED} }}")
    uart.avr.run(0.001)
    uart.line.send(b"\x55" * 3, BAUD, EVEN)
    uart.avr.run(0.01)
    assert uart.heard() not in {b"\x55" * 3, b""}


def test_the_shared_register_reads_format_only_twice_in_a_row() -> None:
    """UBRRH and UCSRC of an ATmega32; a write goes to either, by URSEL, and changes it alone."""
    uart = Uart(
        """int main(void) {
            uint8_t a, b;
            UBRRH = 1; UCSRC = _BV(URSEL) | 0x26; UBRRL = 0x9f;
            values[0] = UBRRH;
            asm volatile("in %0, %2\\n in %1, %2" : "=r"(a), "=r"(b) : "I"(_SFR_IO_ADDR(UBRRH)));
            values[1] = a; values[2] = b; UCSRB = _BV(TXEN); UDR = 1; UDR = 2; for (;;) {}
        }""",
        mcu="atmega32",
    )
    uart.avr.run(0.02)
    assert uart["values"][:3] == [1, 1, 0xA6]
    assert set(np.diff(uart.avr.uarts.take()["end"].astype(int))) == {11 * 16 * 0x1A0}


def test_nine_bits_go_both_ways() -> None:
    uart = listening("atmega328p", 0x06, extra=0x04)
    uart.line.send(b"\x12\x34", BAUD, Format(9, "none", 1), flips=[1 << 9, 0])
    uart.avr.run(0.01)
    assert (uart.heard(), list(uart.heard("ninth"))) == (b"\x12\x34", [2, 0])


def test_a_reset_ends_what_is_received() -> None:
    uart = listening("atmega32", 0x26)
    uart.line.send(b"abc", BAUD, EVEN)
    uart.avr.run(0.0009)
    uart.avr.reset()
    uart.avr.run(0.01)
    assert uart.heard()[-1:] == b"c"


@every_part
def test_one_that_is_not_there_is_an_error(mcu: str) -> None:
    """What is sent to it would be heard by nobody, and seem to have changed nothing."""
    uarts = Uart("int main(void) { for (;;) {} }", mcu=mcu).avr.uarts
    for number in (4, *((0,) if mcu == "atmega32u4" else ())):
        with pytest.raises(IndexError, match=f"no UART {number}"):
            uarts[number]
