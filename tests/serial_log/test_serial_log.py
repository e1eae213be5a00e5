"""The log by itself: every row, every command, every cut of the power."""

import random
from collections.abc import Callable
from functools import cache

import pytest
from rig.avr import Board, Program
from rig.specs import sources_of, spec_of

from heatwright.sim.avr import RAM_FILL
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.serial_log import HEADING, LogRow, SerialLog, attach
from heatwright.spec import SerialLog as Spec
from heatwright.spec.eeprom import layout

SPEC = """
heatwright: 1
controller: {{name: logged, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs: {{heater: {{kind: digital, pin: {heater}, power: 40 W}}}}
loops:
  air:
    {{sensor: air, heater: heater, period: 1 s, algorithm: {{kind: on_off, hysteresis: 2 K}},
     setpoint: {{initial: 10 °C, minimum: 0 °C, maximum: 70 °C}}}}
interfaces: [{{kind: serial_log, loop: air, {said}}}]
"""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "gate.h"
#include "log.h"
#include "log_port.h"
#include "loop_air.h"
#if EEPROM
#include "log_ring_eeprom.h"
#endif

struct loop_air_state loop_air;
volatile uint16_t passes;
volatile uint8_t deaf_ms; /* so that several ticks come at once */

void gate_tick(void)
{
}

int main(void)
{
#if EEPROM
    log_ring_start();
#endif
    log_port_start();
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        for (; deaf_ms != 0; deaf_ms--) {
            __builtin_avr_delay_cycles(F_CPU / 1000UL);
        }
        passes++;
        log_tick();
#if EEPROM
        log_ring_tick();
#endif
    }
}
"""
PINS = {"uno": ("A1", "D3"), "mega2560": ("D22", "D6"), "atmega32": ("PA2", "PD5")}
"""Of sensor and heater, by the board."""
TICK_S = 0.01
RAM = "every: 2 s, entries: 20"
SLOW_RAM = "every: 60 s, entries: 20"
SLOW_LINE = "every: 1 s, entries: 20, baud: 600"
EEPROM = "every: 64 s, entries: 50, keep: eeprom"
OTHER_SPEC = EEPROM.replace("64", "65")
UNKNOWN = ["unknown: write log, clear or help"]
HELP = ["log: the whole log, the oldest first", "clear: forget it", "help: this"]
WRITTEN_S = 0.15
"""Behind an entry's time it is in its memory: eight bytes, one a tick."""
LONGEST_WAIT_S = 100e-6
GUARDED = 256
"""Bytes behind the last variable, far from the stack."""
SOON_S = 0.6
"""Within this long 50 lines of the log have come."""


def shown_c(celsius: float) -> float:
    """Round to what an entry holds: tenths, halves away from zero, within its 16 bits."""
    tenths = min(int(abs(celsius) * 10 + 0.5), 32767)
    return -tenths / 10 if celsius < 0 else tenths / 10


def program(said: str, board: str = "uno") -> Program:
    """Compile clock and log with the program above."""
    sensor, heater = PINS[board]
    text = SPEC.format(board=board, said=said, sensor=sensor, heater=heater)
    names = [name.removesuffix(".c") for name in sources_of(text) if name.endswith(".c")]
    chosen = [name for name in names if name.startswith(("clock", "log"))]
    kept = "log_ring_eeprom.h" in sources_of(text)
    return Program(text, tuple(chosen), MAIN, (f"-DEEPROM={int(kept)}",))


class LogBoard(Board):
    """A processor that runs it, the computer that reads it, and what it should say."""

    def __init__(self, program: Program, elf: Elf | None = None, eeprom: bytes = b"") -> None:
        """Power on; with another binary, and what is in the EEPROM, if there is."""
        self.elf = elf or program.elf()
        self._program = program
        self.controller = spec_of(program.spec).controller
        super().__init__(self.elf, self.controller.board)
        (interface,) = self.controller.interfaces
        assert isinstance(interface, Spec)
        self.interface = interface
        if eeprom:
            self.avr.eeprom.contents = eeprom
        self.computer: SerialLog = attach(self.avr, self.board, interface)
        self.avr.run(TICK_S / 2)
        self.reads(0.0)

    def with_eeprom(self, contents: bytes) -> "LogBoard":
        """Power on the same program with this in the EEPROM."""
        return LogBoard(self._program, self.elf, contents)

    def after_power_cut(self, undefined: int = 0xFF) -> "LogBoard":
        """Power it on with the EEPROM as a loss of power leaves it now."""
        return self.with_eeprom(self.avr.eeprom.after_power_cut(undefined))

    def reads(self, temperature_c: float | None, setpoint_c: float = 20.0) -> None:
        """Let the loop read this from now on; None: nothing."""
        self.put("loop_air.has_reading", 1)
        self.put("loop_air.missing", int(temperature_c is None))
        if temperature_c is not None:
            self.put("loop_air.temperature_c", temperature_c)
        self.put("loop_air.setpoint_c", setpoint_c)

    def run(self, seconds: float) -> None:
        """Go on, and let the computer hear."""
        self.avr.run(seconds)
        self.computer.feed(self.avr.pins.take(), self.avr.uarts.take())

    def ask(self, command: str, seconds: float = 1.0) -> list[str]:
        """Send a command and return the lines that came."""
        self.computer.write(command)
        self.run(seconds)
        return self.computer.texts


class Notes:
    """A board's readings from entry to entry, and the rows that they must become."""

    def __init__(self, bench: LogBoard) -> None:
        self.bench = bench
        self.rows: list[LogRow] = []
        self.every_s = round(bench.interface.every_s)
        bench.run(WRITTEN_S)
        self._spent_s = 0.0

    def go(self, temperature_c: float | None, setpoint_c: float = 20.0) -> None:
        """Go on until the next entry is noted."""
        self.bench.reads(temperature_c, setpoint_c)
        self.bench.run(self.every_s - self._spent_s)
        self._spent_s = 0.0
        shown = None if temperature_c is None else shown_c(temperature_c)
        time_s = self.rows[-1].time_s if self.rows else 0
        self.rows.append(LogRow(time_s + self.every_s, shown, shown_c(setpoint_c)))

    def wait(self, temperature_c: float) -> None:
        """Go on until shortly before the next entry."""
        self.bench.reads(temperature_c)
        most_s = self.every_s - 2 * WRITTEN_S
        self.bench.run(most_s - self._spent_s)
        self._spent_s = most_s

    def ask(self, command: str) -> list[str]:
        """Send a command and return the lines that came, within the time of an entry."""
        self._spent_s += SOON_S
        return self.bench.ask(command, SOON_S)

    def begin_anew(self) -> None:
        """The log was cleared: its time begins with the command."""
        self.rows.clear()
        self._spent_s = SOON_S - WRITTEN_S

    def check(self, when: str) -> None:
        """Read the log: it has a heading, what is due, and an empty line."""
        texts, due = self.ask("log"), self.rows[-self.bench.interface.entries :]
        assert (texts[:1], texts[-1:], len(texts)) == ([HEADING], [""], len(due) + 2), when
        assert f"{self.bench.computer.rows}" == f"{due}", when  # 0.0 and not -0.0


def course(bench: LogBoard, laps: int = 6) -> None:
    """Note so many laps of the log, and read them."""
    notes, entries = Notes(bench), bench.interface.entries
    notes.check("nothing noted")
    for celsius, setpoint_c in (
        (21.04, 20.0), (-0.04, 0.0), (-0.06, -0.05), (-250.05, 1000.0), (None, 9.96),
        (1372.04, 99.95), (5000.0, 4000.0), (-5000.0, -4000.0), (100.0, 0.5),
    ):  # fmt: skip
        notes.go(celsius, setpoint_c)
    notes.check("a few")
    for number in range(laps * entries + 7):
        notes.go(20.0 + number, 1000.0 - number)
        if number in {entries - 10, entries - 9, entries - 8, entries, laps * entries + 6}:
            notes.check(f"{number} more")
    notes.go(1.0)
    assert notes.ask("clear") == ["cleared"]
    notes.begin_anew()
    notes.check("cleared")
    notes.wait(50.0)  # an entry that came by the time before it was cleared would have this
    notes.go(2.0)
    notes.go(3.0)
    notes.check("after it was cleared")


def no_reading(bench: LogBoard) -> None:
    """No temperature is told before there was one."""
    notes = Notes(bench)
    bench.reads(7.0)
    bench.put("loop_air.has_reading", 0)
    bench.run(notes.every_s)
    assert notes.ask("log") == [HEADING, f"{notes.every_s},,20.0", ""]


def commands(bench: LogBoard) -> None:
    """What is sent, whole, damaged, or more than is taken in a tick, and what is answered."""
    notes, computer = Notes(bench), bench.computer
    notes.go(5.0)
    row = [HEADING, f"{notes.every_s},5.0,20.0", ""]

    def answers(sent: bytes, gap_s: float = TICK_S / 20, flips: tuple[int, ...] = ()) -> list[str]:
        computer.lines.clear()
        bench.avr.uarts[0].send(sent, computer.baud, gap_s=gap_s, flips=flips)
        bench.run(0.4)
        return computer.texts

    for sent, due in (
        (b"help\n", HELP), (b"help\r\n", HELP), (b"\r\n\n\r", []), (b"log\r", row),
        (b"logs\n", UNKNOWN), (b"lo\n", UNKNOWN), (b"hello\n", UNKNOWN), (b"helphelp\n", UNKNOWN),
        (b"helphelphelp\n", UNKNOWN), (b"helphelphelphelp\nlog\n", UNKNOWN + row),
        (b"a" * 250 + b"\nlog\n", UNKNOWN + row), (b"x\nhelp\n", UNKNOWN + HELP),
        (b"log\nhelp\n", [HEADING, *HELP]), (b"\0help\n", UNKNOWN),
        (b"he\0lp\nlog\n", UNKNOWN + row), (b"log\0\n", UNKNOWN),
    ):  # fmt: skip
        assert answers(sent) == due, sent
    assert answers(b"log\n", flips=(0, 1 << 9, 0, 0)) == UNKNOWN, "a stop bit is damaged"
    too_many = answers(b"log" + b"\n" * 40, gap_s=0.0)  # for its receiver, in one tick
    computer.send_bytes(b"\n")
    bench.run(0.4)
    assert UNKNOWN[0] in too_many + computer.texts
    assert answers(b"log\n", gap_s=TICK_S) == row
    behind = bench.avr.read_ram(bench.elf.static_ram[1], GUARDED)
    assert set(behind) == {RAM_FILL}, "something is written behind all variables"


def slow(bench: LogBoard) -> None:
    """The line is so slow that the ring goes on while it is read."""
    notes = Notes(bench)
    for number in range(25):
        notes.go(float(number))
    bench.computer.write("log")
    bench.run(60.0)
    assert (bench.computer.texts[:1], bench.computer.texts[-1]) == ([HEADING], "")
    rows = bench.computer.rows
    times = [row.time_s for row in rows]
    assert times == list(range(6, max(27, times[-1]) + 1))
    assert all(row.temperature_c == row.time_s - 1 for row in rows if row.time_s <= 25)


def kept(bench: LogBoard, each: int = 1) -> None:
    """Cut the power at each (or every so many) moments of writing: the log goes on behind it."""
    notes = Notes(bench)
    for number in range(53):
        notes.go(float(number))
    bench.run(notes.every_s - WRITTEN_S - 2 * TICK_S)
    for cut in range(30):
        bench.reads(99.0, 98.0)
        bench.run(TICK_S / 2 if cut else TICK_S)
        for undefined in (0x00, 0xFF, 0x35) if cut % each == 0 else ():
            _goes_on(bench.after_power_cut(undefined), notes)
    _is_forgotten(bench)


def _goes_on(after: LogBoard, notes: Notes) -> None:
    rows, every_s = notes.rows, notes.every_s
    assert after.ask("log", SOON_S)[:1] == [HEADING]
    held = after.computer.rows
    new = LogRow(every_s * 54, 99.0, 98.0)
    # The oldest is given up when the newest begins to be written in its place.
    assert held in (rows[-50:], rows[-49:], [*rows[-49:], new])
    after.reads(1.0)
    after.run(every_s + WRITTEN_S)
    after.ask("log", SOON_S)
    assert after.computer.rows[-1] == LogRow(every_s * (55 if new in held else 54), 1.0, 20.0)
    assert not after.avr.eeprom.violations, "the EEPROM was touched while it wrote"


def _is_forgotten(bench: LogBoard) -> None:
    """What was cleared does not come back, and what is of another spec or lap is no entry."""
    bench.ask("clear", SOON_S)
    assert bench.after_power_cut().ask("log", SOON_S) == [HEADING, ""]
    assert bench.with_eeprom(full(OTHER_SPEC)).ask("log", SOON_S) == [HEADING, ""]
    image = bytearray(full(EEPROM))
    start = layout(bench.controller).history.start
    for place in (start + 8 * 3, start + 8 * 3 + 7):
        image[place] -= 1
    other = bench.with_eeprom(bytes(image))
    other.ask("log", SOON_S)
    assert len(other.computer.rows) == 49


@cache
def full(said: str) -> bytes:
    """Return the EEPROM of a sound board, its log full."""
    notes = Notes(LogBoard(program(said)))
    for number in range(60):
        notes.go(float(number))
    return notes.bench.avr.eeprom.contents


def busy(bench: LogBoard) -> None:
    """The log does not wait for the EEPROM when ticks follow each other without a pause."""
    bench = bench.with_eeprom(full(EEPROM))
    profile = bench.avr.profile(bench.elf)
    bench.ask("log", SOON_S)
    usual = profile.functions["log_tick"].longest
    bench.run(bench.interface.every_s - SOON_S - 3 * TICK_S)
    bench.computer.write("log")
    for _ in range(10):
        bench.put("deaf_ms", 35)
        bench.run(4 * TICK_S)
    wait_s = (profile.functions["log_tick"].longest - usual) / bench.avr.clock_hz
    assert wait_s <= LONGEST_WAIT_S


def flood(bench: LogBoard) -> None:
    """A flood of anything misses no tick."""
    drawn = random.Random(1)  # noqa: S311 - no secret
    begun_s, passes = bench.avr.time_s, int(bench.get("passes"))
    words = [b"log\n", b"clear\n", b"help\n", b"\r", b"\n", b"\0", b"\xff"]
    while bench.avr.time_s < begun_s + 10:
        bench.computer.send_bytes(b"".join([drawn.randbytes(500), *drawn.choices(words, k=20)]))
        bench.run(0.05)
    bench.run(1.0)
    assert int(bench.get("passes")) - passes == round((bench.avr.time_s - begun_s) / TICK_S)
    bench.ask("clear")
    bench.ask("")
    assert bench.ask("help")[0].startswith("log")


BOARDS = [
    ("uno", RAM), ("mega2560", f"{RAM}, port: 1"), ("mega2560", f"{RAM}, port: 3, baud: 9600"),
    ("atmega32", RAM), ("uno", EEPROM), ("atmega32", EEPROM),
]  # fmt: skip


@pytest.mark.parametrize(("board", "said"), BOARDS)
def test_on_every_board(board: str, said: str) -> None:
    course(LogBoard(program(said, board)))


@pytest.mark.parametrize(
    ("said", "check"),
    [
        (RAM, no_reading), (EEPROM, no_reading), (RAM, flood), (EEPROM, flood),
        (SLOW_RAM, commands),  # so slow that none is noted meanwhile
        (EEPROM, commands), (SLOW_LINE, slow), (EEPROM, busy), (EEPROM, kept),
    ],
)  # fmt: skip
def test_it_stands(said: str, check: Callable[[LogBoard], None]) -> None:
    check(LogBoard(program(said)))
