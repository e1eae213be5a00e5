"""simavr's known traits: each is worked around in the shim, and here is held to be."""

import resource

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, Small, powered, running, shared

from heatwright.sim.avr import AvrError

EVERY = ("atmega328p", "atmega32", "atmega16")
every_part = pytest.mark.parametrize("mcu", EVERY)

IDLE = """
volatile uint8_t ticks;
ISR(TIMER1_COMPA_vect) { ticks++; PINB = _BV(PB5); }
static void tick_start(void) {
    DDRB = _BV(PB5); TCCR1B = _BV(WGM12) | _BV(CS11); OCR1A = 19999; TIMSK1 = _BV(OCIE1A);
}
"""
SLEEP = "sleep_enable(); sei(); sleep_cpu(); sleep_disable(); cli();"


@pytest.mark.parametrize(
    ("before", "loop", "asleep"),
    [
        ("", SLEEP, True),
        # simavr polls a low interrupt pin every cycle and is awake for it, unless told not to.
        ("EIMSK = _BV(INT0);", SLEEP, True),
        ("sei();", "sleep_cpu();", False),  # without permission it is no sleep
    ],
)
def test_sleep_is_jumped_over(before: str, loop: str, *, asleep: bool) -> None:
    avr = running(
        f"""{IDLE} ISR(INT0_vect) {{}}
        int main(void) {{ {before} tick_start(); for (;;) {{ {loop} }} }}"""
    )
    avr.pins.drive("PD2", "low")
    avr.run(20 if asleep else 0.1)
    assert (avr.sleep_cycles > 0.99 * avr.cycle) if asleep else avr.sleep_cycles == 0


def test_a_polled_uart_does_not_put_the_simulator_to_sleep(monkeypatch: pytest.MonkeyPatch) -> None:
    """simavr sleeps 1 µs of wall time at each look at an idle UART: its flag for that is off."""
    avr = running("""
        volatile uint32_t looks;
        int main(void) { UCSR0B = _BV(RXEN0); for (;;) { (void)UCSR0A; looks++; } }""")
    switches = resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw
    avr.run(1)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw - switches < 10_000


def test_sent_bytes_are_not_printed(capfd: pytest.CaptureFixture[str]) -> None:
    avr = running("int main(void) { UCSR0B = _BV(TXEN0); UDR0 = 'x'; UDR0 = '\\n'; for (;;) {} }")
    avr.run(0.1)
    assert capfd.readouterr() == ("", "")


def test_the_cut_of_a_run_and_single_steps_do_not_show() -> None:
    """Bursts, stops and yields are the shim's own business: traces are equal to the cycle."""
    program = shared("blink.c")
    whole, pieces, stepped = processors = [powered(program) for _ in range(3)]
    for avr in processors:
        avr.pins.watch("PB5")
    stepped.profile(program)
    for avr in (whole, stepped):
        avr.run_to(3_000_000)
    rng = np.random.default_rng(1)
    while pieces.cycle < 3_000_000:
        pieces.run_to(min(3_000_000, pieces.cycle + int(rng.integers(1, 50_000))))
    trace = whole.pins.take()
    for other in (pieces, stepped):
        assert np.array_equal(trace, other.pins.take())
        assert (whole.cycle, whole.sleep_cycles) == (other.cycle, other.sleep_cycles)


@pytest.mark.parametrize("cycle", [1_000_003, 1_234_567, 1_999_999])
def test_a_sleeping_processor_stops_at_the_very_cycle(cycle: int) -> None:
    avr = running(f"{IDLE} int main(void) {{ tick_start(); for (;;) {{ {SLEEP} }} }}")
    avr.run_to(cycle)
    assert avr.cycle == cycle


def test_a_busy_processor_stops_at_the_end_of_an_instruction() -> None:
    avr = running("int main(void) { for (;;) PORTB++; }")
    for cycle in range(1_000, 1_100, 7):
        avr.run_to(cycle)
        assert cycle <= avr.cycle < cycle + 4


WATCHDOG = """
uint8_t cause __attribute__((section(".noinit")));
void early(void) __attribute__((naked, used, section(".init3")));
void early(void) { cause = MCUSR; MCUSR = 0; wdt_disable(); }
"""


@pytest.mark.parametrize(
    ("hang", "setting", "seconds"),
    [
        ("for (;;) {}", "WDTO_250MS", 0.25),
        ("for (;;) {}", "WDTO_2S", 2.0),
        ("cli(); sleep_enable(); for (;;) sleep_cpu();", "WDTO_2S", 2.0),
        (f"tick_start(); for (;;) {{ {SLEEP} }}", "WDTO_2S", 2.0),
        ("sei(); sleep_enable(); for (;;) sleep_cpu();", "WDTO_1S", 1.0),
    ],
)
def test_the_watchdog_bites_in_time(hang: str, setting: str, seconds: float) -> None:
    """Busy, asleep for good, asleep between ticks, asleep with nothing to wake for."""
    avr = running(f"{IDLE}{WATCHDOG} int main(void) {{ wdt_enable({setting}); {hang} }}")
    avr.run(3.5 * seconds)
    resets = avr.take_resets()
    assert (resets["cause"].tolist(), resets["mcusr"].tolist()) == ([3, 3, 3], [8, 8, 8])
    assert resets["cycle"][0] / CLOCK_HZ == pytest.approx(seconds * 1.024, rel=1e-4)


def test_reset_flags_add_up_until_cleared() -> None:
    avr = running("int main(void) { wdt_enable(WDTO_15MS); for (;;) {} }")
    avr.run(0.02)
    avr.reset("brown_out")
    avr.reset("external")
    assert [int(flags) for flags in avr.take_resets()["mcusr"]] == [0b1001, 0b1101, 0b1111]


BITES = {
    # simavr goes on with the old timeout until the next WDR.
    "a new one counts at once": (EVERY, "wdt_enable(WDTO_15MS); wdt_enable(WDTO_1S);", 0.9, 0.2),
    "it is reset and switched off": (
        EVERY,
        """wdt_enable(WDTO_15MS);
        for (uint8_t i = 0; i < 100; i++) { _delay_ms(10); wdt_reset(); }
        wdt_disable(); _delay_ms(100); wdt_enable(WDTO_15MS);""",
        1.11, 0.02,
    ),
    # Within four cycles after WDTOE only; the timeout of old ones may be changed at any time.
    "it is not switched off by one write": (
        EVERY[1:],
        """WDTCR = _BV(WDE); WDTCR = 0; WDTCR = _BV(WDTOE) | _BV(WDE); _delay_us(1); WDTCR = 0;
        WDTCR = _BV(WDE) | 2;""",
        0.065, 0.005,
    ),
}  # fmt: skip


@pytest.mark.parametrize(("what", "mcu"), [(what, mcu) for what in BITES for mcu in BITES[what][0]])
def test_the_watchdog_bites_then_and_no_earlier(what: str, mcu: str) -> None:
    _, source, quiet_s, then_s = BITES[what]
    avr = running(source, mcu=mcu)
    avr.run(quiet_s)
    assert len(avr.take_resets()) == 0
    avr.run(then_s)
    assert len(avr.take_resets()) == 1


def test_cli_sleep_is_for_good_without_a_watchdog() -> None:
    avr = running("int main(void) { cli(); sleep_enable(); sleep_cpu(); for (;;) PORTB++; }")
    avr.pins.watch("PB0")
    avr.run(1)
    assert avr.hung
    assert not len(avr.pins.take())


def test_a_waiting_interrupt_ends_sleep_at_once() -> None:
    """`sei; sleep; cli` back to back: on the part the interrupt comes before the cli."""
    avr = running(
        """
        volatile uint8_t ticks;
        ISR(TIMER1_COMPA_vect) { ticks++; }
        int main(void) {
            DDRB = 1; TCCR1B = _BV(WGM12) | _BV(CS10); OCR1A = 999; TIMSK1 = _BV(OCIE1A);
            sleep_enable();
            for (;;) {
                while (!(TIFR1 & _BV(OCF1A))) {}
                asm volatile("sei\\n\\tsleep\\n\\tcli");
                PORTB = ticks & 1;
            }
        }"""
    )
    avr.pins.watch("PB0")
    avr.run(0.01)
    assert len(avr.pins.take()) > 150


@every_part
def test_entering_an_interrupt_takes_the_parts_four_cycles(mcu: str) -> None:
    """From a busy loop: a timer's match to the first instruction of the handler."""
    avr = running(
        """
        ISR(TIMER1_COMPA_vect, ISR_NAKED) {
            asm volatile("lds r24, %0\\n\\tsts 0x100, r24\\n\\t1: rjmp 1b"
                         :: "n"(_SFR_MEM_ADDR(TCNT1)));
        }
        int main(void) {
            TCCR1B = _BV(WGM12) | _BV(CS10); OCR1A = 999; MASK = _BV(OCIE1A);
            sei();
            for (;;) asm volatile("nop");
        }""",
        f"-DMASK={'TIMSK1' if mcu == 'atmega328p' else 'TIMSK'}",
        mcu=mcu,
    )
    avr.run(0.001)
    assert 4 + 3 <= avr.read_ram(0x100, 1)[0] <= 4 + 3 + 3  # entry, jmp, rest of an instruction


LIMITS = {
    "((void (*)(void))0x3fff)();": "flash byte 0x",
    r'asm("push %0\n push %0\n push %0\n reti" :: "r"(0x7f));': "flash byte 0x",
    "set_sleep_mode(SLEEP_MODE_PWR_DOWN); sei(); sleep_mode();": "sleep mode other than idle",
    "set_sleep_mode(SLEEP_MODE_ADC); sei(); sleep_mode();": "sleep mode other than idle",
    "DDRD = 8; OCR2B = 9; TCCR2A = 0x21; TCCR2B = 2;": "phase-correct PWM on timer 2",
    "UCSR0C = 0x46;": "not simulated",
    "UCSR0A = 1;": "not simulated",
}
OF_ALL = [(source, mcu) for source in list(LIMITS)[:4] for mcu in (*EVERY, "atmega2560")]


@pytest.mark.parametrize(
    ("source", "mcu"), [*OF_ALL, *((source, EVERY[0]) for source in list(LIMITS)[4:])]
)
def test_what_is_not_simulated_ends_the_run_and_says_so(source: str, mcu: str) -> None:
    avr = running(source, mcu=mcu)
    avr.pins.watch("PD3")
    with pytest.raises(AvrError, match=LIMITS[source]):
        avr.run(0.1)


OLD = pytest.mark.parametrize("mcu", ["atmega32", "atmega16"])

WATCHDOG_HZ = 1_000_000  # at 5 V (data sheets, table "Watchdog Timer Prescale Select")

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
        ISR(TIMER0_COMP_vect) { n0++; } ISR(TIMER1_COMPA_vect) { n1++; }
        ISR(TIMER2_COMP_vect) { n2++; }
        int main(void) {
            OCR0 = 99; TCCR0 = _BV(WGM01) | 2; OCR1A = 1999; TCCR1B = _BV(WGM12) | 1;
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
}  # fmt: skip


@OLD
@pytest.mark.parametrize("what", COUNTED)
def test_timers_and_their_flags(mcu: str, what: str) -> None:
    source, seconds, expected = COUNTED[what]
    program = Small(source, mcu=mcu, seconds=seconds)
    for name, value in expected.items():
        assert program[name] == pytest.approx(value, abs=1 if value >= 400 else 0)


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
    assert (resets["cause"].tolist(), resets["mcusr"].tolist()) == ([3], [8])
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
