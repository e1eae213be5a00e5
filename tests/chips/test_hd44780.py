"""The HD44780 and its bus against the data sheet."""

import numpy as np
import pytest
from rig.avr import CLOCK_HZ, running

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.character_rom import A00
from heatwright.sim.interfaces.hd44780 import Hd44780, Times
from heatwright.sim.interfaces.lcd import BusLimits, Lcd
from heatwright.sim.native.pins import PIN_EVENT, pin_number

MS = 1_000_000
US = 1_000


class Writer(Hd44780):
    """The chip, written to with the waits the data sheet asks for; initialised at the start."""

    def __init__(self, times: Times | None = None, *, patience: float = 1.0) -> None:
        super().__init__(*([times] if times else []))
        self.patience, self.now = patience, 16 * MS
        self.initialise()

    def nibble(self, rs: int, value: int, wait: int) -> None:
        self.write(self.now, rs, value)
        self.now += round(wait * self.patience)

    def byte(self, rs: int, value: int, wait: int = 42 * US) -> None:
        self.nibble(rs, value >> 4, US)
        self.nibble(rs, value & 15, wait)

    def commands(self, *values: int) -> None:
        for value in values:
            self.byte(0, value, 1_600 * US if value in {0x01, 0x02} else 42 * US)

    def initialise(self) -> None:
        """By instruction, for four lines (data sheet, figure 24)."""
        for value, wait in ((3, 4_100 * US), (3, 100 * US), (3, 40 * US), (2, 40 * US)):
            self.nibble(0, value, wait)
        self.commands(0x28, 0x08, 0x01, 0x06, 0x0C)

    def say(self, address: int, text: str) -> None:
        self.commands(0x80 | address)
        for char in text:
            self.byte(1, A00.index(char))


def test_two_rows_of_text() -> None:
    blank = Hd44780()
    assert (blank.ready, blank.text) == (False, (" " * 16, " " * 16))
    chip = Writer()
    chip.say(0x00, "T=49.9°C VT=1   ")
    chip.say(0x40, "Set temp 50°C")
    assert chip.ready
    assert chip.text == ("T=49.9°C VT=1   ", "Set temp 50°C   ")
    chip.commands(0x08)  # off keeps the text
    assert chip.text[0].strip() == ""
    chip.commands(0x0C)
    assert chip.text[0].startswith("T=49.9")
    assert chip.lost == 0


def test_character_codes() -> None:
    assert len(A00) == 256
    assert A00[0x20:0x7E].replace("¥", "\\") == "".join(map(chr, range(0x20, 0x7E)))
    assert (A00[223], A00[0xE4], A00[0xF4], A00[0xFF]) == ("°", "μ", "Ω", "█")


@pytest.mark.parametrize("half", [0, 1])
def test_it_is_initialised_from_any_state(half: int) -> None:
    """The processor may be reset in the middle of a byte; the display is not."""
    chip = Writer()
    chip.say(0, "before")
    for _ in range(half):
        chip.nibble(0, 0x8, 40 * US)
    chip.initialise()
    chip.say(0, "after")
    assert chip.text[0] == "after".ljust(16)
    assert chip.lost == 0


def test_writes_while_busy_are_lost() -> None:
    early = Hd44780()
    early.write(10 * MS, 0, 3)
    assert early.lost == 1  # still in its own reset
    chip = Writer()
    chip.byte(0, 0x01, wait=40 * US)  # clearing takes 1.52 ms
    chip.byte(1, ord("x"))
    assert chip.lost == 2
    assert chip.text[0].strip() == ""


@pytest.mark.parametrize(("oscillator_hz", "lost"), [(270_000, False), (190_000, True)])
def test_a_slow_chip_needs_longer(oscillator_hz: float, lost: bool) -> None:
    assert (Writer(Times().at(oscillator_hz)).lost > 0) == lost
    assert Writer(Times().at(oscillator_hz), patience=1.5).lost == 0


COURSES = {
    "the first row ends at 0x27, the second starts at 0x40": [(0x27, "ab", 1, "b")],
    "backwards": [([0x04], "", 0, ""), (0x0F, "zyx", 0, " " * 13 + "xyz")],
    "the second row ends at 0x67, the first follows": [(0x67, "cd", 0, "d")],
    "the display is shifted": [
        (0, "0123456789abcdefghij", 0, "0123456789abcdef"), ([0x18], "", 0, "123456789abcdefg"),
        ([0x1C, 0x1C], "", 0, " 0123456789abcde"), ([0x02], "", 0, "0123456789abcdef"),
    ],
    "the cursor moves": [([0x14], "b", 0, " b"), ([0x10, 0x10], "a", 0, "ab")],
    "own characters": [([0x40], "■" * 8, 0, ""), (0, "■", 0, "■")],
}  # fmt: skip
"""Commands or an address, what is said then; a row, and what it shows."""


@pytest.mark.parametrize("what", COURSES)
def test_what_is_shown(what: str) -> None:
    chip = Writer()
    for where, text, row, shown in COURSES[what]:
        chip.commands(*(where if isinstance(where, list) else [0x80 | where]))
        for char in text:
            chip.byte(1, A00.index(char))
        assert chip.text[row] == shown.ljust(16)


PINS = ("PB0", "PB1", "PD4", "PD5", "PD6", "PD7")
DRIVER = """
static void nibble(uint8_t rs, uint8_t v) {
    PORTD = (PORTD & 0x0f) | (v << 4);
    if (rs) PORTB |= 1; else PORTB &= ~1;
    PORTB |= 2; _delay_us(0.5); PORTB &= ~2; _delay_us(WAIT_US);
}
static void byte(uint8_t rs, uint8_t v) { nibble(rs, v >> 4); nibble(rs, v & 15); }
static void text(uint8_t at, const char *s) { byte(0, 0x80 | at); while (*s) byte(1, *s++); }
static void start(void) {
    DDRB = 3; DDRD = 0xf0; _delay_ms(16);
    nibble(0, 3); _delay_ms(5); nibble(0, 3); _delay_us(100); nibble(0, 3); nibble(0, 2);
    byte(0, 0x28); byte(0, 0x08); byte(0, 1); _delay_ms(2); byte(0, 6); byte(0, 12);
}
"""


def watched(program: str, *flags: str) -> Avr:
    avr = running(DRIVER + program, *flags)
    for pin in PINS:
        avr.pins.watch(pin)
    return avr


def shown(text: str, wait_us: int = 50) -> Lcd:
    avr = watched(f"int main(void) {{ start(); {text} for (;;) {{}} }}", f"-DWAIT_US={wait_us}")
    lcd = Lcd(PINS, CLOCK_HZ)
    for _ in range(7):
        avr.run(0.0123)
        lcd.feed(avr.pins.take())
    return lcd


def test_a_program_drives_it() -> None:
    lcd = shown('text(0, "hello"); text(0x40, "world \\xdf");')
    assert lcd.text == ("hello           ", "world °         ")
    assert (lcd.violations, lcd.chip.lost) == ({}, 0)
    rows = [screen.rows[0].strip() for screen in lcd.history]
    assert rows[1:6] == ["h", "he", "hel", "hell", "hello"]
    assert 0.02 < lcd.history[1].time_s < lcd.history[-1].time_s < 0.05
    assert lcd.writes == 4 + 2 * (5 + 6 + 8)


def test_an_impatient_program_is_found_out() -> None:
    assert shown('text(0, "hello");', wait_us=10).chip.lost > 0


BUS_FAULTS = {
    "enable_width": "PORTB |= 2; PORTB &= ~2;",
    "data_hold": "PORTB |= 2; _delay_us(1); PORTB = 0; PORTD ^= 0x10;",
    "data_setup": "PORTB |= 2; _delay_us(1); PORTD ^= 0x10; PORTB &= ~2;",
    "address_setup": "PORTB |= 1; PORTB |= 2; _delay_us(1); PORTB = 0;",
    "address_hold": "PORTB = 1; _delay_us(1); PORTB |= 2; _delay_us(1); PORTB = 0;",
    "enable_cycle": "PORTB |= 2; _delay_us(.4); PORTB &= ~2; PORTB |= 2; _delay_us(1); PORTB = 0;",
}


@pytest.mark.parametrize("fault", BUS_FAULTS)
def test_a_bus_too_fast_is_noticed(fault: str) -> None:
    """Limits are tightened where an AVR at 16 MHz cannot be fast enough to break them."""
    program = f"int main(void) {{ DDRB = 3; DDRD = 0xf0; {BUS_FAULTS[fault]} for (;;) {{}} }}"
    avr = watched(program, "-DWAIT_US=50")
    slow = {"data_hold": 400, "address_setup": 200, "data_setup": 200}
    limits = BusLimits(**{fault: slow[fault]}) if fault in slow else BusLimits()
    lcd = Lcd(PINS, CLOCK_HZ, limits)
    avr.run(0.001)
    lcd.feed(avr.pins.take())
    assert lcd.violations.get(fault) == 1


def test_the_batches_do_not_matter() -> None:
    program = 'int main(void) { start(); for (;;) { text(0, "tick"); text(0, "tock"); } }'
    avr = watched(program, "-DWAIT_US=50")
    avr.run(0.1)
    events = avr.pins.take()
    whole, parts = Lcd(PINS, CLOCK_HZ), Lcd(PINS, CLOCK_HZ)
    whole.feed(events)
    for part in np.array_split(events, 97):
        parts.feed(part)
    assert whole.history == parts.history
    assert len(whole.history) > 100


def test_other_pins_and_changes_of_source_alone_are_passed_over() -> None:
    lcd = Lcd(PINS, CLOCK_HZ)
    events = np.zeros(4, PIN_EVENT)
    events["pin"] = [pin_number("PC3"), pin_number("PB1"), pin_number("PB1"), pin_number("PD4")]
    events["state"] = [1, 4 << 1, 0, 0]
    lcd.feed(events)
    assert (lcd.writes, lcd.violations) == (0, {})


def test_a_display_pulled_off_forgets() -> None:
    lcd = shown('text(0, "x");')
    lcd.unplug(0.1)
    assert lcd.text == (" " * 16, " " * 16)
    lcd.plug(0.2)
    assert not lcd.chip.ready
    assert [screen.rows[0].strip() for screen in lcd.history] == ["", "x", ""]
