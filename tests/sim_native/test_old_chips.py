"""ATmega16 and ATmega32: what their older peripherals do, held to the data sheets."""

import numpy as np
import pytest
from rig.avr import CLOCK_HZ, running
from rig.small import Small

OLD = pytest.mark.parametrize("mcu", ["atmega32", "atmega16"])

WATCHDOG_HZ = 1_000_000
"""The watchdog's oscillator at 5 V (data sheets, table "Watchdog Timer Prescale Select": 16.3 ms
for 16384 of its cycles)."""

CTC = {
    "0": ("OCR0 = 249; TCCR0 = _BV(WGM01)", "0_COMP", "OCIE0", (1, 8, 64, 256, 1024)),
    "1": ("OCR1A = 249; TCCR1B = _BV(WGM12)", "1_COMPA", "OCIE1A", (1, 8, 64, 256, 1024)),
    "2": ("OCR2 = 249; TCCR2 = _BV(WGM21)", "2_COMP", "OCIE2", (1, 8, 32, 64, 128, 256, 1024)),
}


@OLD
@pytest.mark.parametrize(
    ("timer", "code"), [(timer, code) for timer, row in CTC.items() for code in range(len(row[3]))]
)
def test_a_timer_that_clears_on_compare(mcu: str, timer: str, code: int) -> None:
    """A match every 249 + 1 counts; simavr's timer 0 knows no mode but the normal one."""
    setup, vector, enable, prescalers = CTC[timer]
    avr = running(
        f"""ISR(TIMER{vector}_vect) {{ PORTC ^= 1; }} /* its pull-up comes and goes */
        int main(void) {{ TIMSK = _BV({enable}); {setup} | {code + 1}; sei(); for (;;) {{}} }}""",
        mcu=mcu,
    )
    avr.pins.watch("PC0")
    period = 250 * prescalers[code]
    avr.run_to(20 * period)
    cycles = avr.pins.take()["cycle"].astype(int)
    assert len(cycles) >= 18
    assert np.all(abs(np.diff(cycles) - period) <= 3)
    assert abs(cycles[-1] - cycles[0] - (len(cycles) - 1) * period) <= 3


COUNTED = {
    # Each interrupt comes as often as its timer says, whatever the others are told.
    "three timers share their registers": (
        """volatile uint16_t n0, n1, n2;
        ISR(TIMER0_COMP_vect) { n0++; }
        ISR(TIMER1_COMPA_vect) { n1++; }
        ISR(TIMER2_COMP_vect) { n2++; }
        int main(void) {
            OCR0 = 99; TCCR0 = _BV(WGM01) | 2;
            OCR1A = 1999; TCCR1B = _BV(WGM12) | 1;
            OCR2 = 124; TCCR2 = _BV(WGM21) | 2;
            TIMSK = _BV(OCIE0) | _BV(OCIE1A) | _BV(OCIE2); sei();
            for (;;) {}
        }""",
        0.05, {"n0": 1000, "n1": 400, "n2": 800},
    ),
    # TIFR belongs to three timers; simavr forgets the flags of all when one is cleared.
    "a flag is cleared alone": (
        """volatile uint8_t before, after, last;
        int main(void) {
            OCR0 = 10; OCR2 = 10; OCR1A = 10; OCR1B = 20; TCCR0 = 1; TCCR2 = 1; TCCR1B = 1;
            _delay_us(100);
            before = TIFR; TIFR = _BV(OCF1A); TCCR0 = 0; TCCR1B = 0; TCCR2 = 0; after = TIFR;
            TIFR = 0xff; last = TIFR;
            for (;;) {}
        }""",
        0.001, {"before": 0b11011011, "after": 0b11001011, "last": 0},
    ),
    # What waits while interrupts are off is forgotten; another timer's is not.
    "a cleared flag is no interrupt": (
        """volatile uint8_t n0, n2;
        ISR(TIMER0_COMP_vect) { n0++; }
        ISR(TIMER2_COMP_vect) { n2++; }
        int main(void) {
            OCR0 = 10; OCR2 = 10; TIMSK = _BV(OCIE0) | _BV(OCIE2); TCCR0 = 1; TCCR2 = 1;
            _delay_us(8); TCCR0 = 0; TCCR2 = 0;
            TIFR = _BV(OCF0); sei(); for (;;) {}
        }""",
        0.001, {"n0": 0, "n2": 1},
    ),
    # PIN is read-only on these parts; the newer ones toggle PORT.
    "writing a pin register does nothing": (
        """volatile uint8_t levels;
        int main(void) {
            DDRC = 0x0f; PORTC = 2; PINC = 0x0f; PINC |= 1; PINC |= _BV(2); _delay_us(1);
            levels = PINC & 0x0f; for (;;) {}
        }""",
        0.001, {"levels": 2},
    ),
    "sleep is idle and wakes by a timer": (
        """volatile uint16_t ticks;
        ISR(TIMER2_COMP_vect) { ticks++; }
        int main(void) {
            OCR2 = 249; TCCR2 = _BV(WGM21) | 4; TIMSK = _BV(OCIE2);
            for (;;) { sleep_enable(); sei(); sleep_cpu(); sleep_disable(); cli(); }
        }""",
        1, {"ticks": 1000},
    ),
}  # fmt: skip


@OLD
@pytest.mark.parametrize("what", COUNTED)
def test_timers_and_their_flags(mcu: str, what: str) -> None:
    source, seconds, expected = COUNTED[what]
    program = Small(source, mcu=mcu, seconds=seconds)
    for name, value in expected.items():
        assert program[name] == pytest.approx(value, abs=1 if value >= 400 else 0)
    if "sleep" in what:
        assert program.avr.sleep_cycles > 0.99 * program.avr.cycle


@OLD
@pytest.mark.parametrize(
    ("setting", "code"), [("WDTO_15MS", 0), ("WDTO_250MS", 4), ("WDTO_1S", 6), ("WDTO_2S", 7)]
)
def test_the_watchdog_bites_in_time_and_is_off_after_it(mcu: str, setting: str, code: int) -> None:
    """simavr has the newer parts' oscillator, and leaves the watchdog on after its reset."""
    avr = running(
        f"""uint8_t cause __attribute__((section(".noinit")));
        void early(void) __attribute__((naked, used, section(".init3")));
        void early(void) {{ cause = MCUCSR; MCUCSR = 0; PORTC = WDTCR; }}
        int main(void) {{
            if (cause & _BV(WDRF)) for (;;) {{}}
            wdt_enable({setting}); for (;;) {{}}
        }}""",
        mcu=mcu,
    )
    seconds = (16384 << code) / WATCHDOG_HZ
    avr.run(2.5 * seconds)
    resets = avr.take_resets()
    assert [int(cause) for cause in resets["cause"]] == [3]
    assert [int(flags) for flags in resets["mcusr"]] == [8]
    assert resets["cycle"][0] / CLOCK_HZ == pytest.approx(seconds, rel=1e-4, abs=1e-5)
    assert avr.read_ram(0x35, 1) == b"\0"


@OLD
def test_reset_causes(mcu: str) -> None:
    program = Small(
        """volatile uint8_t first;
        int main(void) { first = MCUCSR; MCUCSR = _BV(ISC2); for (;;) {} }""",
        mcu=mcu,
    )
    program.avr.run(0.001)
    assert program["first"] == 1
    for cause, flag in (("external", 2), ("brown_out", 4)):
        program.avr.reset(cause)  # type: ignore[arg-type]
        program.avr.run(0.001)
        assert program["first"] == flag
    assert [int(flags) for flags in program.avr.take_resets()["mcusr"]] == [2, 4]
