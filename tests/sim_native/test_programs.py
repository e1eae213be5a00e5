"""ELF files, their debug information, and where their cycles go; waveforms."""

import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, compiled, powered, shared
from vcd.reader import TokenKind, tokenize

from heatwright.sim.avr import Avr
from heatwright.sim.binary.dwarf import Variables
from heatwright.sim.binary.elf import Elf, ElfError
from heatwright.sim.binary.profile import Profile
from heatwright.sim.judges.limit import limit_of
from heatwright.sim.plots.vcd import VcdRecorder

SOURCE = """
typedef enum { OFF, ON = 3 } mode_t;
struct point { int16_t x, y; };
struct state {
    uint8_t code; float temperature; bool latched; mode_t mode; int32_t big; uint64_t huge;
    struct point path[3]; uint8_t grid[2][4]; const char *name; double also; int8_t small;
    union { uint16_t word; uint8_t bytes[2]; } both;
};
volatile struct state state;
static volatile uint8_t hidden;
const uint32_t spec_digest PROGMEM __attribute__((used)) = 0x12ab34cd;
uint8_t in_eeprom[4] EEMEM = {1, 2, 3, 4};
volatile uint16_t initialised = 0x1234;
volatile uint8_t kept __attribute__((section(".noinit")));
int main(void) {
    static volatile uint8_t local = 9;
    state.code = 7; state.temperature = 1.5f; state.latched = true; state.mode = ON;
    state.big = -5; state.huge = 1ULL << 40; state.path[2].y = -7; state.grid[1][3] = 99;
    state.small = -1; state.both.word = 0x0102; hidden = local; kept = in_eeprom[0]; kept = 4;
    state.name = (const char *)0x123; state.also = -2.5;
    for (;;) {}
}
"""

PLAIN = {"hidden": 9, "initialised": 0x1234, "local": 9, "kept": 4}


@pytest.fixture(params=["", "-flto"], ids=["plain", "lto"])
def program(request: pytest.FixtureRequest) -> Elf:
    return compiled(SOURCE, *([request.param] if request.param else []))


def test_values_as_the_program_sets_them(program: Elf) -> None:
    avr = powered(program)
    avr.run(0.001)
    first, end = program.static_ram
    image = np.frombuffer(avr.read_ram(first, end - first), np.uint8).reshape(1, -1)
    seen = Variables(program).decode(image, first, ["state", *PLAIN])[0]
    state = seen["state"]
    assert (state["code"], state["temperature"], state["latched"]) == (7, 1.5, True)
    assert (state["mode"], state["big"], state["huge"], state["small"]) == (3, -5, 1 << 40, -1)
    assert (state["path"][2]["y"], state["grid"][1][3]) == (-7, 99)
    assert (state["both"]["word"], state["both"]["bytes"].tolist()) == (0x0102, [2, 1])
    assert (state["name"], state["also"]) == (0x123, -2.5)
    assert [seen[name] for name in PLAIN] == list(PLAIN.values())


def test_names_that_are_not_there(program: Elf) -> None:
    variables = Variables(program)
    for name, message in (
        ("nowhere", "no variable nowhere"),
        ("state.nothing", "state has no member nothing .it has code, temp"),
        ("state.path[3]", "no element 3"), ("hidden[0]", "hidden has no element 0"),
        ("state..code", "not the name"), ("", "not the name"), ("state code", "not the name"),
    ):  # fmt: skip
        assert name not in variables
        with pytest.raises(ElfError, match=message):
            variables[name]
    assert "state.code" in variables
    with pytest.raises(ElfError, match="hidden is not in the RAM range"):
        variables.decode(np.zeros((2, 4), np.uint8), 0x700, ["hidden"])


def test_static_variables_are_told_apart_by_their_files(tmp_path: Path) -> None:
    for name in ("a", "b"):
        source = f"static volatile char same; void {name}(void) {{ same++; }}"
        (tmp_path / f"{name}.c").write_text(source)
    program = compiled(
        "void a(void); void b(void); int main(void) { a(); b(); for (;;) {} }",
        *["-x", "c", str(tmp_path / "a.c"), str(tmp_path / "b.c")],
    )
    variables = Variables(program)
    assert variables["a.c:same"].address != variables["b.c:same"].address
    with pytest.raises(ElfError, match="several files: name the file"):
        variables["same"]


def test_constants_in_flash(program: Elf) -> None:
    assert int.from_bytes(program.flash_bytes("spec_digest", 4), "little") == 0x12AB34CD
    with pytest.raises(ElfError, match="no constant nothing"):
        program.flash_bytes("nothing", 4)
    assert program.eeprom == b"\x01\x02\x03\x04"


def test_functions() -> None:
    program = shared("blink.c")
    main = program.function("main")
    assert (program.function_at(main.start), program.function_at(main.end - 1)) == (main, main)
    assert program.function_at(main.end) != main
    assert program.function_at(len(program.flash) + 100) is None
    assert all(first.end == second.start for first, second in pairwise(program.functions))
    with pytest.raises(ElfError, match="no function nothing"):
        program.function("nothing")


PROFILED = """
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
    program = compiled(PROFILED)
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


TENTH = """
ISR(TIMER1_COMPA_vect) { _delay_us(100); }
int main(void) {
    TCCR1B = _BV(WGM12) | _BV(CS11); OCR1A = 1999; TIMSK1 = _BV(OCIE1A);
    sleep_enable(); sei();
    for (;;) sleep_cpu();
}
"""


@pytest.mark.parametrize(("source", "share"), [("", 1), (TENTH, 0.1)])
def test_the_limit_is_what_the_cycles_awake_take(source: str, share: float) -> None:
    program = compiled(source)
    avr = powered(program)
    avr.run(1)
    start_s = time.process_time()
    avr.run(1)
    took_s = time.process_time() - start_s
    limit = limit_of(avr, "atmega328p", program)
    assert limit.awake_per_s == pytest.approx(share * CLOCK_HZ, rel=0.05)
    assert limit.cycle_s * limit.awake_per_s == pytest.approx(1 / limit.speed)
    assert 0.2 < took_s * limit.speed < 5, "busy as this computer may be, it is the same one"


def test_the_longest_stretches_and_the_lines_reached(profiled: Profiled) -> None:
    profile, _ = profiled
    masked, busy, functions = profile.masked, profile.busy, profile.functions
    assert (masked.function, masked.cycles) == ("masks", pytest.approx(702, abs=4))
    assert masked.seconds == masked.cycles / CLOCK_HZ
    assert functions["masks"].masked == masked.cycles
    assert functions["__vector_11"].masked == pytest.approx(300 + 4 + 3 + 27, abs=15)
    assert functions["waits"].masked == 0
    assert (busy.function, busy.cycles) == ("waits", pytest.approx(5000, abs=10))
    lines = profile.lines()["test.c"]
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
    for ask in (lambda: first.functions, lambda: first.reached, lambda: first.busy, first.stop):
        with pytest.raises(ValueError, match="has been stopped"):
            ask()
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
