"""Pins: who sets the level, for how long it is high, and the outputs of timers."""

import numpy as np
import pytest
from rig.avr import CLOCK_HZ, running

from heatwright.sim.native.pins import Source, pin_name, pin_number


def states(avr: object) -> list[tuple[int, Source]]:
    events = avr.pins.take()  # type: ignore[attr-defined]
    return [(int(state) & 1, Source(int(state) >> 1)) for state in events["state"]]


def test_names() -> None:
    assert pin_number("PB5") == 13
    assert [pin_name(pin_number(name)) for name in ("PA0", "PD3", "PL7")] == ["PA0", "PD3", "PL7"]
    for wrong in ("D3", "PB8", "PM0", "", "PB", "PBB"):
        with pytest.raises(ValueError, match="not a pin"):
            pin_number(wrong)


def test_a_pin_the_part_lacks() -> None:
    with pytest.raises(ValueError, match="no pin PA0"):
        running("int main(void) { for (;;) {} }").pins.watch("PA0")


def test_every_driver_in_its_order_of_strength() -> None:
    """A pin that floats keeps its level."""
    avr = running("PORTB = 1; DDRB = 1; PORTB = 0; DDRB = 0; PORTB = 1; PORTB = 0; PORTB = 1;")
    avr.pins.watch("PB0")
    avr.run(0.001)
    assert states(avr) == [
        (1, Source.PULL_UP), (1, Source.MCU), (0, Source.MCU), (0, Source.FLOATING),
        (1, Source.PULL_UP), (1, Source.FLOATING), (1, Source.PULL_UP),
    ]  # fmt: skip
    avr.pins.pull("PB0", "low")
    avr.pins.drive("PB0", "high")
    avr.pins.drive("PB0", None)
    avr.pins.pull("PB0", None)
    assert states(avr) == [
        (0, Source.RESISTOR), (1, Source.OTHERS), (0, Source.RESISTOR), (1, Source.PULL_UP),
    ]  # fmt: skip


def test_the_program_reads_what_is_outside() -> None:
    avr = running("int main(void) { DDRC = 1; for (;;) PORTC = (PINB >> 3) & 1; }")
    for level in ("high", "low", "high"):
        avr.pins.drive("PB3", level)
        avr.pins.watch("PC0")
        avr.run(0.001)
        assert avr.pins.level("PC0") == (level == "high")


def test_an_outside_edge_is_an_interrupt_and_a_held_level_is_none() -> None:
    avr = running(
        """
        ISR(PCINT0_vect) { PORTC++; }
        int main(void) {
            DDRC = 0x3f; PCICR = 1; PCMSK0 = 0x08; PORTB = 0x08; PCIFR = 1; sei();
            for (;;) { PORTB ^= 1; }
        }"""
    )
    avr.pins.pull("PB3", "high")
    avr.run(0.001)
    before = avr.read_ram(0x28, 1)[0]
    for level in ("low", "high", "low", None):
        avr.pins.drive("PB3", level)
        avr.run(0.001)
    assert avr.read_ram(0x28, 1)[0] - before == 4


def test_contention_is_counted() -> None:
    avr = running("DDRB = 1; PORTB = 1;")
    avr.pins.drive("PB0", "low")
    avr.run(0.01)
    assert avr.pins.contention_cycles("PB0") == pytest.approx(0.01 * CLOCK_HZ, rel=0.01)
    assert not avr.pins.level("PB0")


def test_high_time_is_exact() -> None:
    on, off = (f"PINB = 1; __builtin_avr_delay_cycles({each});" for each in (997, 2993))
    avr = running(f"DDRB = 1; for (;;) {{ {on} {off} }}")
    number = avr.pins.watch("PB0")
    avr.run_to(100_000)
    start, high = avr.cycle, avr.pins.high_cycles(number)
    avr.run_to(start + 4_000_000)
    edges = avr.pins.take()
    on = (avr.pins.high_cycles(number) - high) / (avr.cycle - start)
    period = np.diff(edges["cycle"][-5::2].astype(int))[0]
    pulse = int(edges["cycle"][-1]) - int(edges["cycle"][-2])
    pulse = pulse if edges["state"][-2] & 1 else int(period) - pulse
    assert on == pytest.approx(pulse / period, abs=period / 4_000_000)
    assert avr.pins.rises(number) == int((edges["state"] & 1).sum())


def test_a_reset_lets_go_of_the_pins_at_once() -> None:
    avr = running("_delay_ms(1); DDRD = 8; PORTD = 8; wdt_enable(WDTO_30MS);")
    avr.pins.pull("PD3", "low")
    avr.pins.watch("PD3")
    avr.run(0.1)
    resets, events = avr.take_resets(), avr.pins.take()
    assert len(resets) > 1
    for reset in resets:
        after = events[events["cycle"] == reset["cycle"]]
        assert [int(state) for state in after["state"]] == [Source.RESISTOR << 1]


TIMERS = {
    # Part, pin, counts, prescaler, set-up, compare register.
    "timer 2, fast, 8 bits": (
        "atmega328p", "PD3", 256, 8, "TCCR2A = 0x03 | COM << 4; TCCR2B = 0x02;", "OCR2B"),
    "timer 1, mode 14": (
        "atmega328p", "PB1", 1000, 1, "ICR1 = 999; TCCR1A = 0x02 | COM << 6; TCCR1B = 0x19;",
        "OCR1A"),
    "timer 1, mode 15": (
        "atmega328p", "PB2", 400, 8, "OCR1A = 399; TCCR1A = 0x03 | COM << 4; TCCR1B = 0x1a;",
        "OCR1B"),
    "timer 0, mode 7": (
        "atmega328p", "PD5", 100, 64, "OCR0A = 99; TCCR0A = 0x03 | COM << 4; TCCR0B = 0x0b;",
        "OCR0B"),
} | {
    f"{mcu}, {compare}": (mcu, pin, counts, prescaler, setup, compare)
    for mcu in ("atmega32", "atmega16")
    for pin, counts, prescaler, setup, compare in (
        ("PB3", 256, 8, "TCCR0 = _BV(WGM01) | _BV(WGM00) | COM << 4 | 2;", "OCR0"),
        ("PD7", 256, 32, "TCCR2 = _BV(WGM21) | _BV(WGM20) | COM << 4 | 3;", "OCR2"),
        ("PD5", 1000, 1, "ICR1 = 999; TCCR1A = 2 | COM << 6; TCCR1B = 0x19;", "OCR1A"),
        ("PD4", 1000, 8, "ICR1 = 999; TCCR1A = 2 | COM << 4; TCCR1B = 0x1a;", "OCR1B"),
    )
}  # fmt: skip


@pytest.mark.parametrize("timer", TIMERS)
@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99, 1.0])
def test_fast_pwm(timer: str, inverted: bool, share: float) -> None:
    """High for OCR + 1 of TOP + 1 counts; at TOP constantly, without a gap (data sheets)."""
    mcu, pin, counts, prescaler, setup, compare = TIMERS[timer]
    value = min(round(share * counts), counts - 1)
    source = f"DDRB = DDRD = 0xff; {setup} {compare} = {value}; for (;;) PORTC ^= 0x20;"
    avr = running(source, f"-DCOM={3 if inverted else 2}", mcu=mcu)
    number, period = avr.pins.watch(pin), counts * prescaler
    avr.run_to(10 * period)
    avr.pins.take()
    start, high = avr.cycle, avr.pins.high_cycles(number)
    avr.run_to(start + 200 * period)
    on = (avr.pins.high_cycles(number) - high) / (avr.cycle - start)
    expected = (value + 1) / counts
    assert on == pytest.approx(1 - expected if inverted else expected, abs=1 / 200)
    edges = avr.pins.take()["cycle"].astype(int)
    assert len(edges) == (0 if value == counts - 1 else pytest.approx(400, abs=3))
    assert np.all(abs(np.diff(edges[::2]) - period) <= 4)


def test_writing_the_port_does_not_disturb_a_timers_pin() -> None:
    """The display shares port D with the heater: simavr makes false edges there."""
    setup = "DDRD = 0xff; OCR2B = 127; TCCR2A = 0x23; TCCR2B = 0x06;"
    avr = running(f"{setup} for (;;) PIND = 0xf0;")
    avr.pins.watch("PD3")
    avr.run(0.1)
    cycles = avr.pins.take()["cycle"].astype(int)
    gaps = set(np.diff(cycles[2:]).tolist())
    assert all(abs(gap - 128 * 256) < 20 for gap in gaps), gaps


def test_phase_correct_pwm_is_refused() -> None:
    avr = running("DDRD = 8; OCR2B = 9; TCCR2A = 0x21; TCCR2B = 2;")
    avr.pins.watch("PD3")
    with pytest.raises(RuntimeError, match="phase-correct PWM on timer 2"):
        avr.run(0.1)


def test_a_pin_to_which_two_timers_lead() -> None:
    """It belongs to the one that is connected: timer 1's channel C is set up after timer 0 is."""
    avr = running(
        """DDRB = 0x80; TCCR0A = 0x83; OCR0A = 63; TCCR0B = 2;
        ICR1 = 999; TCCR1A = 0x82; TCCR1B = 0x19; OCR1A = 500;""",
        mcu="atmega2560",
    )
    number = avr.pins.watch("PB7")
    avr.run(0.001)
    before = avr.pins.high_cycles(number)
    avr.run(256 * 8 * 10 / CLOCK_HZ)
    assert avr.pins.high_cycles(number) - before == pytest.approx(64 * 8 * 10, abs=4)
