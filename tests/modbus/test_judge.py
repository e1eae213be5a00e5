"""The simulated master judges its slave: here are slaves that do one thing wrong each."""

from operator import attrgetter

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
RELEASE = "PORTD &= (uint8_t)~_BV(2);"


HARMLESS = {"WAIT": "2500", "DRIVE": "PORTD |= _BV(2);", "RELEASE": RELEASE, "MIDDLE": "",
            "BEFORE": ""}  # fmt: skip


def met(answer: bytes = GOOD, **parts: str) -> ModbusMaster:
    """A master that has polled such a slave for three and a half seconds, over RS-485."""
    parts = {"ANSWER": ", ".join(map(str, answer)), **HARMLESS, **parts}
    avr = powered(compiled(SLAVE, *(f"-D{name}={text}" for name, text in parts.items())))
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


TICK_S = EVEN.bits / BAUD
WRONG = [
    GOOD[:-1] + bytes([GOOD[-1] ^ 1]), GOOD[:-1], GOOD + b"\0",
    *(frames.framed(*each) for each in (
        (2, bytes([4, 2, 0, 0])), (1, bytes([3, 2, 0, 0])), (1, bytes([0x84])),
        (1, bytes([4, 4, 0, 0, 0, 0])), (1, bytes([4, 4, 0, 0])),
    )),
]  # fmt: skip
EARLY = "PORTD &= 0xFB;"


TOO_LATE = {"WAIT": str(round(1.5e6 * ANSWER_S))}


@pytest.mark.parametrize("answer", WRONG)
def test_a_wrong_answer(answer: bytes) -> None:
    master = met(answer)
    assert (master.damaged, master.polls, master.values) == (3, 0, {})


@pytest.mark.parametrize(
    ("slave", "polls", "more_than_none"),
    [
        ({"ANSWER": "1"}, 0, "damaged"),
        ({"BEFORE": "UCSR0C = 0x36;"}, 0, "damaged"),
        ({"MIDDLE": "if (n == 3) _delay_us(6000);"}, 0, "damaged"),
        ({"DRIVE": "", "RELEASE": ""}, 0, "bus.unheard"),
        ({"MIDDLE": f"if (n == 6) {{ while (!(UCSR0A & _BV(UDRE0))) {{}} {EARLY} }}"}, 0,
         "bus.unheard"),
        ({"BEFORE": f"while (!(UCSR0A & _BV(RXC0))) {{}} PORTD |= _BV(2); {EARLY}"}, None,
         "bus.collisions"),
        ({"BEFORE": "_delay_ms(100); PORTD |= 4; put(1);"
                    f"while (!(UCSR0A & _BV(TXC0))) {{}} {EARLY}"}, None, "strangers"),
        (TOO_LATE, 0, "unanswered"),
        (TOO_LATE, 0, "strangers"),
    ],
    ids=[
        "silence", "wrong_format", "two_pieces", "driver_never_on", "driver_off_with_the_last_byte",
        "driver_on_while_the_master_sends", "unasked", "too_late", "too_late_is_a_stranger",
    ],
)  # fmt: skip
def test_what_it_does_wrong_is_counted(
    slave: dict[str, str], polls: int | None, more_than_none: str
) -> None:
    """UDRE instead of TXC lets the driver go with the last byte on its way: the classic."""
    master = met(**slave)
    assert attrgetter(more_than_none)(master) > 0
    assert polls in (None, master.polls)


@pytest.mark.parametrize(
    ("slave", "what", "seconds", "within_s"),
    [
        ({"WAIT": "2005 + 6000"}, "slowest_s", 0.006, TICK_S),
        ({"MIDDLE": "_delay_us(1200);"}, "longest_gap_s", 0.0012, TICK_S),
        ({"RELEASE": f"_delay_us(300); {RELEASE}"}, "bus.slowest_release_s", 300e-6, 1 / BAUD),
    ],
    ids=["late", "gaps", "driver_held_too_long"],
)
def test_what_takes_too_long_is_measured(
    slave: dict[str, str], what: str, seconds: float, within_s: float
) -> None:
    """Gaps may be shorter by a character: the slave has a buffer to go on from."""
    master = met(**slave)
    assert master.polls == 3
    assert attrgetter(what)(master) == pytest.approx(seconds, abs=within_s)
