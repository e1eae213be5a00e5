"""Keys, serial line, switches, and the stepper's driver: what it counts and finds fault with."""

import numpy as np
import pytest
from rig.avr import CLOCK_HZ, running
from rig.small import Small

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.keypad import CODES, Keypad
from heatwright.sim.interfaces.lcd_keypad import LcdKeypad
from heatwright.sim.interfaces.serial_plotter import SerialPlotter
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


def test_keys_give_the_shields_codes() -> None:
    reader = Small(READER)
    keypad = LcdKeypad(reader.avr, UNO).keypad
    for key, code in CODES.items():
        keypad.press(key)
        reader.avr.run(0.001)
        assert reader["code"] == code
    with pytest.raises(ValueError, match="no key fire"):
        keypad.press("fire")


@pytest.mark.parametrize("tolerance", [-0.05, 0.05])
def test_resistors_have_tolerances(tolerance: float) -> None:
    reader = Small(READER)
    Keypad(reader.avr, 0, tolerance=tolerance).press("left")
    reader.avr.run(0.001)
    assert reader["code"] == int(481 * (1 + tolerance) + 0.5)


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


def test_lines_are_understood() -> None:
    plotter = listened("$49.87 50.00 10.00 -0.34;\\n$1;\\r\\n$-2.5 3;\\n")
    due = [(49.87, 50.0, 10.0, -0.34), (1.0,), (-2.5, 3.0)]
    assert [line.values for line in plotter.lines] == due
    assert plotter.garbage == 0
    assert plotter.lines[0].time_s == pytest.approx(25 * 10 * 16 * 104 / CLOCK_HZ, abs=1e-4)


@pytest.mark.parametrize("text", ["hello;", "$;", "$1  2;", "$1.;", "$nan;", "$1,2;", "$1 ;"])
def test_other_text_is_garbage(text: str) -> None:
    plotter = listened(f"{text}\\n$1.00;\\n")
    assert [line.values for line in plotter.lines] == [(1.0,)]
    assert plotter.garbage == len(text)


def test_a_wrong_speed_is_garbage() -> None:
    plotter = listened("$1;\\n", divisor=51)
    assert plotter.speed_error == pytest.approx(1.0, abs=0.01)
    assert (plotter.lines, plotter.garbage) == ([], 4)
    assert abs(listened("$1;\\n").speed_error) < 0.002


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
    assert not switch.on
    assert not switch.driven
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
    assert driver.position_mm == pytest.approx(0.03)
    assert driver.travel_mm() == pytest.approx(0.03)
    assert driver.travel_mm() == 0
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


def test_none_without_enable() -> None:
    driver = driven(f"{PULSE * 3} {ENABLE} {WAIT} {PULSE}")
    assert (driver.position, driver.violations, driver.missed) == (-1, 0, 3)


def test_the_boards_resistor_holds_it_off() -> None:
    assert not driven("DDRB = 0;").on


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
