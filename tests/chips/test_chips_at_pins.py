"""Keys, serial line, switches, the stepper's driver, the HD44780 and its bus (data sheets)."""

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, Small, running

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.lcd import BusLimits, Lcd
from heatwright.sim.interfaces.lcd.hd44780 import A00, Hd44780, Times
from heatwright.sim.interfaces.lcd_keypad import LcdKeypad
from heatwright.sim.interfaces.lcd_keypad.keypad import CODES, Keypad
from heatwright.sim.interfaces.serial_plotter import SerialPlotter
from heatwright.sim.native.pins import PIN_EVENT, pin_number
from heatwright.sim.outputs.stepper import Stepper, attach
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import BOARDS
from heatwright.spec import Stepper as StepperOutput

UNO = BOARDS["uno"]
READER = """
volatile uint16_t code;
int main(void) {
    ADMUX = _BV(REFS0); ADCSRA = 0x87;
    for (;;) { ADCSRA |= _BV(ADSC); while (ADCSRA & _BV(ADSC)) {} code = ADC; }
}
"""


@pytest.mark.parametrize("tolerance", [-0.05, 0.0, 0.05])
def test_keys_give_the_shields_codes(tolerance: float) -> None:
    """With the tolerance of its resistors."""
    reader = Small(READER)
    keypad = LcdKeypad(reader.avr, UNO).keypad
    keypad.tolerance = tolerance
    for key, code in CODES.items():
        keypad.press(key)
        reader.avr.run(0.001)
        assert reader["code"] == int(code * (1 + tolerance * (key is not None)) + 0.5)
    with pytest.raises(ValueError, match="no key fire"):
        keypad.press("fire")


def test_a_bouncing_key() -> None:
    reader = Small(READER)
    keypad = Keypad(reader.avr, 0, bounces=2)
    keypad.press("up")
    seen = []
    for tenth_ms in range(60):
        keypad.advance(round(tenth_ms * 1e-4 * CLOCK_HZ))
        if seen[-1:] != [reader["code"]]:
            seen.append(reader["code"])
    assert seen[-5:] == [131, 1023, 131, 1023, 131]


PLOTTER = """
static void out(char c) {{ while (!(UCSR0A & _BV(UDRE0))) {{}} UDR0 = c; }}
int main(void) {{
    UBRR0 = {divisor}; UCSR0B = _BV(TXEN0);
    for (const char *c = "{text}"; *c; c++) out(*c);
    for (;;) {{}}
}}
"""


def listened(text: str, divisor: int = 103) -> SerialPlotter:
    avr = running(PLOTTER.format(divisor=divisor, text=text))
    plotter = SerialPlotter(avr, 9600)
    for _ in range(10):
        avr.run(0.02)
        plotter.feed(avr.pins.take(), avr.uarts.take())
    return plotter


def test_lines_are_understood_and_those_of_a_wrong_speed_are_garbage() -> None:
    plotter = listened("$49.87 50.00 10.00 -0.34;\\n$1.00;\\n$-2.50 3.00;\\n")
    due = [(49.87, 50.0, 10.0, -0.34), (1.0,), (-2.5, 3.0)]
    assert [line.values for line in plotter.lines] == due
    assert (plotter.ended, plotter.garbage) == (2, 0)
    assert plotter.lines[0].time_s == pytest.approx(25 * 10 * 16 * 104 / CLOCK_HZ, abs=1e-4)
    assert abs(plotter.speed_error) < 0.002
    quick = listened("$1;\\n", divisor=51)
    assert quick.speed_error == pytest.approx(1.0, abs=0.01)
    assert (quick.lines, quick.garbage) == ([], 4)


@pytest.mark.parametrize("text", ["hello;", "$;", "$1  2;", "$1.;", "$nan;", "$1,2;", "$1 ;"])
def test_other_text_is_garbage(text: str) -> None:
    plotter = listened(f"{text}\\n$1.00;\\n")
    assert [line.values for line in plotter.lines] == [(1.0,)]
    assert plotter.garbage == len(text)


SWITCH = """
int main(void) {
    _delay_ms(1);
    DDRD = 8;
    for (;;) { PORTD = 8; _delay_ms(3); PORTD = 0; _delay_ms(1); }
}
"""


@pytest.mark.parametrize(("active", "share"), [("high", 0.75), ("low", 0.25)])
def test_on_fractions(active: str, share: float) -> None:
    avr = running(SWITCH)
    switch = Switch(avr, UNO, "D3", active)  # type: ignore[arg-type]
    assert (switch.on, switch.driven) == (False, False)
    avr.run(0.001)
    assert switch.on_fraction() == 0  # the board's resistor
    assert switch.on_fraction() == 0  # no time has passed
    avr.run(0.4)
    assert switch.on_fraction() == pytest.approx(share, abs=0.001)
    assert switch.driven
    avr.run(0.002)
    part = switch.on_fraction()
    avr.run(0.002)
    assert part + switch.on_fraction() == pytest.approx(2 * share, abs=0.01)


OUTPUT = StepperOutput.model_validate(
    {
        "kind": "stepper", "step": "D8", "direction": "D9", "enable": "D10",
        "steps": 200, "microsteps": 1, "lead": "2 mm",
        "maximum": "10 mm/s", "acceleration": "10 mm/s²",
    }
)  # fmt: skip
STEP, DIR, ENABLE = "PORTB ^= 1;", "PORTB ^= 2;", "PORTB ^= 4;"
START = "DDRB = 7; PORTB = 4;"
WAIT = "_delay_us(10);"
PULSE = f"{STEP} {WAIT} {STEP} {WAIT}"


def attached(body: str) -> tuple[Avr, Stepper]:
    """A program and its driver: PB0 is STEP, PB1 DIR, PB2 ENABLE (low is on)."""
    avr = running(f"int main(void) {{ {START} {WAIT} {body} for (;;) {{}} }}")
    return avr, attach(avr, UNO, OUTPUT)


def driven(body: str, size: int = 1000) -> Stepper:
    """The driver after a program has run, fed with so many events at a time."""
    avr, driver = attached(body)
    avr.run(0.001)
    events = avr.pins.take()
    for first in range(0, len(events), size):
        driver.feed(events[first : first + size], np.zeros(0))
    return driver


def test_steps_forward_and_backward() -> None:
    driver = driven(f"{ENABLE} {DIR} {WAIT} {PULSE * 5} {DIR} {WAIT} {PULSE * 2}")
    assert (driver.position, driver.violations, driver.missed) == (3, 0, 0)
    assert driver.on
    assert (driver.travel_mm(), driver.travel_mm()) == (pytest.approx(0.03), 0)
    assert driver.steps["way"].tolist() == [1, 1, 1, 1, 1, -1, -1]
    assert (np.diff(driver.steps["cycle"]) >= 320).all()


def test_it_waits_to_be_fed_once_it_has_stepped() -> None:
    avr, driver = attached(f"{ENABLE} {WAIT} {PULSE}")
    avr.run(15e-6)
    assert not driver.waits
    avr.run(0.001)
    assert driver.waits
    driver.feed(avr.pins.take(), np.zeros(0))
    assert not driver.waits


def test_no_step_without_enable() -> None:
    driver = driven(f"{PULSE * 3} {ENABLE} {WAIT} {PULSE}")
    assert (driver.position, driver.violations, driver.missed) == (-1, 0, 3)
    assert not driven("DDRB = 0;").on, "the board's resistor holds it off"


@pytest.mark.parametrize(
    ("body", "violations"),
    [
        # A data sheet's microsecond is 16 cycles; a change of a port takes 3.
        (f"{STEP} __builtin_avr_delay_cycles(24); {STEP}", 1),  # 1.9 us high
        (f"{STEP} __builtin_avr_delay_cycles(30); {STEP}", 0),
        (f"{PULSE} {STEP} {WAIT} {STEP} __builtin_avr_delay_cycles(24); {PULSE}", 1),  # 1.9 us low
        (f"{DIR} {PULSE}", 1),  # 650 ns of set-up
        (f"{DIR} __builtin_avr_delay_cycles(9); {PULSE}", 0),
        (f"{STEP} {DIR} {WAIT} {STEP}", 1),  # 650 ns of hold
        (f"{STEP} __builtin_avr_delay_cycles(9); {DIR} {WAIT} {STEP}", 0),
        (f"{ENABLE} {WAIT} {ENABLE} {PULSE}", 1),
    ],
    ids=["short", "long", "close", "turned", "turned early", "turning", "turned late", "woken"],
)
def test_edges_too_close_are_counted(body: str, violations: int) -> None:
    driver = driven(f"{ENABLE} {WAIT} {body}")
    assert driver.violations == violations


def test_it_does_not_matter_where_the_record_is_cut() -> None:
    body = f"{ENABLE} {DIR} {WAIT} {PULSE * 5} {DIR} {PULSE * 2} {STEP} {DIR} {WAIT} {STEP}"
    whole = driven(body)
    for size in (1, 2, 3, 5):
        parts = driven(body, size)
        assert (parts.position, parts.violations) == (whole.position, whole.violations)


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
    assert (chip.text[0], chip.lost) == ("after".ljust(16), 0)


def test_writes_while_busy_are_lost() -> None:
    early = Hd44780()
    early.write(10 * MS, 0, 3)
    assert early.lost == 1  # still in its own reset
    chip = Writer()
    chip.byte(0, 0x01, wait=40 * US)  # clearing takes 1.52 ms
    chip.byte(1, ord("x"))
    assert (chip.lost, chip.text[0].strip()) == (2, "")


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
    assert shown('text(0, "hello");', wait_us=10).chip.lost > 0, "a program must wait"


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
