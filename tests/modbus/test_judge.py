"""The simulated master judges its slave: here are slaves that do one thing wrong each."""

import pytest
from rig.avr import CLOCK_HZ, compiled, powered

from heatwright.sim.interfaces import modbus_frames as frames
from heatwright.sim.interfaces.modbus_bus import Bus
from heatwright.sim.interfaces.modbus_rtu import ANSWER_S, ModbusMaster
from heatwright.sim.interfaces.registers import Register
from heatwright.sim.native.characters import Format
from heatwright.sim.native.pins import pin_number

BAUD = 19_200
EVEN = Format(8, "even")
MAP = {"speed": Register("input_register", 7, "speed", "i16", 0.5)}
SLAVE = """
static const uint8_t answer[] = { ANSWER };
static void put(uint8_t c) { while (!(UCSR0A & _BV(UDRE0))) {} UCSR0A |= _BV(TXC0); UDR0 = c; }
int main(void)
{
    DDRD = _BV(2);
    UBRR0 = 51; UCSR0C = 0x26; UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    BEFORE
    for (;;) {
        for (uint8_t n = 0; n < 8; n++) { while (!(UCSR0A & _BV(RXC0))) {} (void)UDR0; }
        _delay_us(WAIT);
        DRIVE
        for (uint8_t n = 0; n < sizeof answer; n++) { put(answer[n]); MIDDLE }
        while (!(UCSR0A & _BV(TXC0))) {}
        RELEASE
    }
}
"""
GOOD = frames.framed(1, bytes([4, 2, 0xFF, 0xF6]))
"""Minus ten steps of a half."""
DRIVE, RELEASE = "PORTD |= _BV(2);", "PORTD &= (uint8_t)~_BV(2);"


def met(
    answer: bytes = GOOD,
    *,
    wait_us: int = 2500,
    drive: str = DRIVE,
    release: str = RELEASE,
    middle: str = "",
    before: str = "",
) -> ModbusMaster:
    """A master that has polled such a slave for three and a half seconds, over RS-485."""
    listed = ", ".join(map(str, answer))
    program = compiled(
        SLAVE, f"-DANSWER={listed}", f"-DWAIT={wait_us}", f"-DDRIVE={drive}",
        f"-DRELEASE={release}", f"-DMIDDLE={middle}", f"-DBEFORE={before}",
    )  # fmt: skip
    avr = powered(program)
    avr.pins.pull("PD2", "low")
    avr.pins.watch("PD2")
    master = ModbusMaster(avr, Bus(avr, 0, BAUD, EVEN, pin_number("PD2")), 1)
    master.serve(MAP)
    end = round(3.5 * CLOCK_HZ)
    while (wake := master.wake_cycle) is not None and wake < end:
        avr.run_to(wake)
        master.feed(avr.pins.take(), avr.uarts.take())
    return master


def test_a_good_slave_is_found_good() -> None:
    master = met()
    assert master.polls == 3
    assert master.values == {"speed": -5.0}
    assert (master.unanswered, master.strangers, master.damaged) == (0, 0, 0)
    assert (master.bus.unheard, master.bus.collisions) == (0, 0)
    assert 0 < master.bus.slowest_release_s < 10e-6
    assert master.longest_gap_s < 1.5 * EVEN.bits / BAUD
    assert 0 < master.slowest_s < 0.001


def test_silence() -> None:
    master = met(b"\x01")
    assert master.polls == 0
    assert master.damaged > 0


@pytest.mark.parametrize(
    "answer",
    [
        GOOD[:-1] + bytes([GOOD[-1] ^ 1]),
        GOOD[:-1],
        GOOD + b"\0",
        frames.framed(2, bytes([4, 2, 0, 0])),
        frames.framed(1, bytes([3, 2, 0, 0])),
        frames.framed(1, bytes([0x84])),
        frames.framed(1, bytes([4, 4, 0, 0, 0, 0])),
        frames.framed(1, bytes([4, 4, 0, 0])),
    ],
)
def test_a_wrong_answer(answer: bytes) -> None:
    master = met(answer)
    assert master.damaged == 3
    assert master.polls == 0
    assert master.values == {}


def test_an_answer_in_the_wrong_format() -> None:
    master = met(before="UCSR0C = 0x36;")
    assert master.damaged == 3


def test_a_late_answer() -> None:
    master = met(wait_us=2005 + 6000)
    assert master.slowest_s == pytest.approx(0.006, abs=EVEN.bits / BAUD)


def test_an_answer_too_late_to_be_one() -> None:
    master = met(wait_us=round(1.5e6 * ANSWER_S))
    assert master.polls == 0
    assert master.unanswered >= 2
    assert master.strangers >= 2


def test_an_answer_with_gaps() -> None:
    master = met(middle="_delay_us(1200);")
    assert master.polls == 3
    assert master.longest_gap_s > 0.0012 - EVEN.bits / BAUD  # it has a buffer to go on from


def test_an_answer_in_two_pieces() -> None:
    master = met(middle="if (n == 3) _delay_us(6000);")
    assert master.polls == 0
    assert master.damaged > 0


def test_a_driver_that_is_never_on() -> None:
    master = met(drive="", release="")
    assert master.bus.unheard > 0
    assert master.polls == 0


def test_a_driver_that_is_let_go_with_the_last_byte_on_its_way() -> None:
    """UDRE instead of TXC: the classic."""
    master = met(middle="if (n == 6) { while (!(UCSR0A & _BV(UDRE0))) {} PORTD &= 0xFB; }")
    assert master.bus.unheard > 0
    assert master.polls == 0


def test_a_driver_that_is_held_too_long() -> None:
    master = met(release="_delay_us(300); PORTD &= (uint8_t)~_BV(2);")
    assert master.polls == 3
    assert master.bus.slowest_release_s == pytest.approx(300e-6, abs=1 / BAUD)


def test_a_driver_that_comes_on_while_the_master_sends() -> None:
    master = met(before="while (!(UCSR0A & _BV(RXC0))) {} PORTD |= _BV(2); PORTD &= 0xFB;")
    assert master.bus.collisions > 0


def test_what_nobody_asked_for() -> None:
    master = met(
        before="_delay_ms(100); PORTD |= 4; put(1); while (!(UCSR0A & _BV(TXC0))) {} PORTD &= 0xFB;"
    )
    assert master.strangers == 1
