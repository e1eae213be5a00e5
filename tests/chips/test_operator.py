"""Keys, serial line and switches."""

import pytest
from rig.avr import CLOCK_HZ, running
from rig.small import Small

from heatwright.sim.interfaces.keypad import CODES, Keypad
from heatwright.sim.interfaces.lcd_keypad import LcdKeypad
from heatwright.sim.interfaces.serial_plotter import SerialPlotter
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import BOARDS

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
    assert [line.values for line in plotter.lines] == [
        (49.87, 50.0, 10.0, -0.34),
        (1.0,),
        (-2.5, 3.0),
    ]
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
