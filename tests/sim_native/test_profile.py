"""Profiling: cycles by function, stretches, stack, coverage; waveforms."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rig.avr import CLOCK_HZ, compiled, powered, shared
from vcd.reader import TokenKind, tokenize

from heatwright.sim.avr import Avr
from heatwright.sim.profile import Profile
from heatwright.sim.vcd import VcdRecorder

SOURCE = """
volatile uint8_t n;
ISR(TIMER1_COMPA_vect) { __builtin_avr_delay_cycles(300); n++; }
__attribute__((noinline)) void waits(void) { __builtin_avr_delay_cycles(5000); }
__attribute__((noinline)) void calls(void) { waits(); waits(); }
__attribute__((noinline)) void never(void) { n = 0; }
__attribute__((noinline)) void masks(void) { cli(); __builtin_avr_delay_cycles(700); sei(); }
int main(void) {
    TCCR1B = _BV(WGM12) | _BV(CS10); OCR1A = 1999; TIMSK1 = _BV(OCIE1A);
    sleep_enable(); sei();
    for (;;) {
        calls(); masks();
        for (uint8_t i = 0; i < 10; i++) sleep_cpu();
        if (n == 255) never();
    }
}
"""


Profiled = tuple[Profile, Avr]


@pytest.fixture(scope="module")
def profiled() -> Iterator[Profiled]:
    program = compiled(SOURCE)
    avr = powered(program)
    found = avr.profile(program)
    for function in ("calls", "__vector_11"):
        found.trace(function)
    avr.run(0.005)
    yield found, avr
    found.stop()
    avr.run(0.001)


def test_cycles_by_function(profiled: Profiled) -> None:
    profile, avr = profiled
    functions = profile.functions
    waits, calls, isr = functions["waits"], functions["calls"], functions["__vector_11"]
    assert waits.calls == 2 * calls.calls  # the second call is a jump: calls' last act
    assert waits.longest == pytest.approx(5000, abs=12)  # interrupts not counted
    assert calls.longest == pytest.approx(2 * waits.longest, abs=20)
    assert isr.longest == pytest.approx(300 + 4 + 3 + 27, abs=15)
    assert waits.own == waits.total
    assert calls.own < 30 * calls.calls
    assert "never" not in functions
    awake = avr.cycle - avr.sleep_cycles
    entries = sum(8 * function.calls for name, function in functions.items() if "vector" in name)
    assert 0 <= awake - sum(function.own for function in functions.values()) <= entries
    for name in ("calls", "__vector_11"):
        assert len(profile.entries(name)) == functions[name].calls


def test_the_longest_stretches(profiled: Profiled) -> None:
    profile, _ = profiled
    masked, busy, functions = profile.masked, profile.busy, profile.functions
    assert masked.function == "masks"
    assert masked.cycles == pytest.approx(702, abs=4)
    assert masked.seconds == masked.cycles / CLOCK_HZ
    assert functions["masks"].masked == masked.cycles
    assert functions["__vector_11"].masked == pytest.approx(300 + 4 + 3 + 27, abs=15)
    assert functions["waits"].masked == 0
    assert busy.function == "waits"
    assert busy.cycles == pytest.approx(5000, abs=10)


def test_lines_reached_and_missed(profiled: Profiled) -> None:
    lines = profiled[0].lines()["test.c"]
    assert {3, 4, 5, 7} <= lines.reached
    assert 6 in lines.missed


def test_one_profile_at_a_time_and_the_jitter_of_a_tick() -> None:
    program = shared("blink.c")
    avr = powered(program)
    first = avr.profile(program)
    with pytest.raises(ValueError, match="already being profiled"):
        avr.profile(program)
    first.stop()
    profile = avr.profile(program)
    profile.trace("__vector_11")
    avr.run(1)
    assert set(np.diff(profile.entries("__vector_11").astype(int))) == {160_000}


def test_waveforms(tmp_path: Path) -> None:
    program = compiled(
        """int main(void) {
            DDRB = 1; PORTB = 1; _delay_us(100); PORTB = 0; DDRB = 0;
            UBRR0 = 103; UCSR0B = _BV(TXEN0); UDR0 = 'A'; for (;;) {}
        }"""
    )
    avr = powered(program)
    avr.pins.watch("PB0")
    with VcdRecorder(tmp_path / "x.vcd", {"D8": "PB0"}, avr.clock_hz) as recorder:
        for _ in range(4):
            avr.run(0.00008)
            recorder.feed(avr.pins.take(), avr.uarts.take())
    tokens = list(tokenize((tmp_path / "x.vcd").open("rb")))
    times = [token.time_change for token in tokens if token.kind is TokenKind.CHANGE_TIME]
    changes = [token for token in tokens if token.kind is TokenKind.CHANGE_SCALAR]
    assert [token.scalar_change.value for token in changes] == ["z", "0", "1", "0", "z"]
    assert times[2] - times[1] == pytest.approx(125, abs=130)
    assert max(times) == pytest.approx(101_000, abs=5_000)


def test_loops_of_the_start_up_code_are_no_calls() -> None:
    """Clearing this much memory jumps between labels more often than calls may nest."""
    program = compiled(
        """
        volatile uint8_t cleared[700];
        __attribute__((noinline)) void works(void) { __builtin_avr_delay_cycles(100); }
        int main(void) { for (;;) { works(); cleared[3]++; } }"""
    )
    avr = powered(program)
    profile = avr.profile(program)
    avr.run(0.01)
    assert profile.functions["works"].longest == pytest.approx(104, abs=4)
