"""The log by itself: every row, every command, every cut of the power."""

import random
import struct
from collections.abc import Callable
from math import ceil, inf

import pytest
from rig.firmware import Board, Program, sources_of, spec_of

from heatwright.sim.avr import RAM_FILL
from heatwright.sim.binary.elf import Elf
from heatwright.sim.interfaces.serial_log import HEADING, LogRow, SerialLog, attach
from heatwright.spec import SerialLog as Spec
from heatwright.spec.board.eeprom import layout

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
volatile uint8_t deaf_ms; /* so that several ticks come at once */
volatile bool shut; /* meanwhile, so that bytes overrun each other */

void gate_tick(void)
{
}

int main(void)
{
#if EEPROM
    log_ring_start();
#endif
#ifdef UCSR0C
    UCSR0C = 0; /* as a boot loader may leave it */
#endif
    log_port_set_registers();
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        if (shut) {
            cli();
        }
        for (; deaf_ms != 0; deaf_ms--) {
            __builtin_avr_delay_cycles(F_CPU / 1000UL);
        }
        sei();
        log_tick();
#if EEPROM
        log_ring_tick();
#endif
    }
}
"""
PINS = {"uno": ("A1", "D3"), "mega2560": ("D22", "D6"), "atmega32": ("PA2", "PD5")}
"""Pins of sensor and heater, by the board."""
TICK_S = 0.01
RAM = "every: 2 s, entries: 20"
SLOW_RAM = "every: 60 s, entries: 20"  # so slow that none is noted meanwhile
SLOW_LINE = "every: 1 s, entries: 20, baud: 600"
EEPROM = "every: 64 s, entries: 50, keep: eeprom"
HOURLY = "every: 1 h, entries: 50, keep: eeprom"  # its times have all places
UNKNOWN = ["unknown: write log, clear or help"]
HELP = ["log: the whole log, the oldest first", "clear: forget it", "help: this"]
OTHERS = 50.0, 60.0, 70.0  # what the loop reads, shall and does where nothing is noted
DUTIES = ((0.0, 0), (37.49, 37), (37.5, 38), (99.6, 100), (150.0, 100), (-3.0, 0), (0.4, 0))
"""What a step asks of the heater, %, and what is noted of it."""
ENTRY = "<HhhBBB"  # A slot: lap, temperature, setpoint, duty, digest, the lap's low byte
SLOT = struct.calcsize(ENTRY)
WRITTEN_S = 0.15  # behind an entry's time it is in its memory: nine bytes, one a tick
LONGEST_WAIT_S = 100e-6
GUARDED = 256  # bytes behind the last variable, far from the stack
UCSR0B, UDRIE0 = 0xC1, 1 << 5  # of an ATmega328P
SOON_S = 0.6  # within it 50 lines of the log have come


def shown_c(celsius: float) -> float:
    tenths = min(int(abs(celsius) * 10 + 0.5), 32767)
    return -tenths / 10 if celsius < 0 else tenths / 10


def program(said: str, board: str = "uno") -> Program:
    sensor, heater = PINS[board]
    text = SPEC.format(board=board, said=said, sensor=sensor, heater=heater)
    names = [name.removesuffix(".c") for name in sources_of(text) if name.endswith(".c")]
    chosen = [name for name in names if name.startswith(("clock", "log"))]
    kept = "log_ring_eeprom.h" in sources_of(text)
    return Program(text, tuple(chosen), MAIN, (f"-DEEPROM={int(kept)}",))


class LogBoard(Board):
    def __init__(self, program: Program, elf: Elf | None = None, eeprom: bytes = b"") -> None:
        """Power on; with another binary, and what is in the EEPROM, if there is."""
        self.elf = elf or program.elf()
        self._program, self.text = program, program.spec
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
        return LogBoard(self._program, self.elf, contents)

    def reads(
        self, temperature_c: float | None, setpoint_c: float = 20.0, duty_percent: float = 0.0
    ) -> None:
        """Let the loop read this from now on; None: nothing; infinity: nothing yet."""
        self.put("loop_air.has_reading", int(temperature_c != inf))
        self.put("loop_air.missing", int(temperature_c is None))
        if temperature_c is not None:
            self.put("loop_air.temperature_c", temperature_c)
        self.put("loop_air.setpoint_c", setpoint_c)
        self.put("loop_air.duty_percent", duty_percent)

    def run(self, seconds: float) -> None:
        self.avr.run(seconds)
        self.computer.feed(self.avr.pins.take(), self.avr.uarts.take())

    def adds(self, ticks: float) -> None:
        self.put("log.c:ticks", round(self.interface.every_s / TICK_S) - 1)
        self.run(ticks * TICK_S)

    def rows(self) -> list[LogRow]:
        self.ask("log", SOON_S)
        return self.computer.rows

    def ask(self, command: str, seconds: float = 1.0) -> list[str]:
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
        self.bench.reads(*OTHERS)
        self.bench.run(self.every_s - WRITTEN_S - TICK_S - self._spent_s)
        asked, percent = DUTIES[len(self.rows) % len(DUTIES)]
        self.bench.reads(temperature_c, setpoint_c, asked)
        self.bench.run(TICK_S)
        self.bench.reads(*OTHERS)
        self.bench.run(WRITTEN_S)
        self._spent_s = 0.0
        shown = None if temperature_c in {None, inf} else shown_c(temperature_c or 0.0)
        time_s = self.rows[-1].time_s if self.rows else 0
        self.rows.append(LogRow(time_s + self.every_s, shown, shown_c(setpoint_c), percent))

    def ask(self, command: str) -> list[str]:
        self._spent_s += SOON_S
        return self.bench.ask(command, SOON_S)

    def begin_anew(self) -> None:
        """The log was cleared: its time begins with the tick in which the command had come."""
        self.rows.clear()
        heard_s = len("clear\r") * 10 / self.bench.computer.baud
        self._spent_s = SOON_S - WRITTEN_S - TICK_S * ceil(heard_s / TICK_S + 0.5)

    def check(self, when: str) -> None:
        """Read the log: it has a heading, what is due, and an empty line."""
        texts, due = self.ask("log"), self.rows[-self.bench.interface.entries :]
        assert (texts[:1], texts[-1:], len(texts)) == ([HEADING], [""], len(due) + 2), when
        assert f"{self.bench.computer.rows}" == f"{due}", when  # 0.0 and not -0.0


def course(bench: LogBoard, laps: int = 6) -> None:
    notes, entries = Notes(bench), bench.interface.entries
    notes.check("nothing noted")
    for celsius, setpoint_c in (
        (inf, 7.0), (21.04, 20.0), (-0.04, 0.0), (-0.06, -0.05), (-250.05, 1000.0), (None, 9.96),
        (1372.04, 99.95), (5000.0, 4000.0), (-5000.0, -4000.0), (100.0, 0.5), (0.06, 0.04),
        (-3276.64, 3276.64), (-3276.76, 3276.76),
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
    notes.go(2.0)
    notes.go(3.0)
    notes.check("after it was cleared")


def commands(bench: LogBoard) -> None:
    notes, computer = Notes(bench), bench.computer
    notes.go(5.0)
    row = [HEADING, f"{notes.every_s},5.0,20.0,0", ""]
    bench.avr.pins.watch("PD0")
    assert bench.avr.pins.level("PD0"), "nothing plugged in is silence"
    divisor = round(bench.avr.clock_hz / 8 / computer.baud)
    assert bench.avr.uarts[0].frame_s == 10 * 8 * divisor / bench.avr.clock_hz

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
        (b"he\0lp\nlog\n", UNKNOWN + row), (b"log\0\n", UNKNOWN), (b"a\n", UNKNOWN),
        (b"clea\n", UNKNOWN), (b"clears\n", UNKNOWN), (b"\xecog\n", UNKNOWN),
    ):  # fmt: skip
        assert answers(sent) == due, sent
    assert answers(b"log\n", flips=(0, 1 << 9, 0, 0)) == UNKNOWN, "a stop bit is damaged"
    most = b"\n" * 10 + b"log\n"  # that are held from tick to tick
    assert answers(most, gap_s=0.0) == row
    assert answers(b"\n" + most, gap_s=0.0) + answers(b"\n") == UNKNOWN
    bench.put("shut", 1)
    bench.put("deaf_ms", 1)
    bench.run(TICK_S / 2 + 1e-4)
    assert answers(b"log" + b"!" * 6, gap_s=0.0) == []
    bench.run(TICK_S / 2 - 1e-4)
    assert answers(b"\n") == UNKNOWN, "bytes are lost between it and the word"
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


LAPS = 0xFFFF  # they are counted from 0 to 65534, and from 0 again; an erased slot says 65535


class Image:
    def __init__(self, board: LogBoard) -> None:
        self.start, self._size = layout(board.controller).history.start, board.interface.entries
        self.contents = bytearray(board.avr.eeprom.contents)
        self._digest = int(sources_of(board.text)["config.h"].partition("DIGEST 0x")[2][6:8], 16)

    def put(self, lap: int, place: int, values: tuple[int, int, int]) -> None:
        begins, lap = self.start + SLOT * place, lap % LAPS
        slot = struct.pack(ENTRY, lap, *values, self._digest, lap & 0xFF)
        self.contents[begins : begins + SLOT] = slot

    def whole(self) -> dict[int, tuple[int, int, int, int]]:
        slots = struct.iter_unpack(ENTRY, self.contents[self.start :][: SLOT * self._size])
        return {
            place: (lap, *values) for place, (lap, *values, digest, again) in enumerate(slots)
            if lap != LAPS and (digest, again) == (self._digest, lap & 0xFF)
        }  # fmt: skip

    def end(self) -> tuple[int, int]:
        """Return lap and place of the entry that comes next: behind the newest."""
        newest = 0, -1
        for place, (lap, *_) in self.whole().items():
            if newest[1] < 0 or (lap - newest[0] + 0x8000 & 0xFFFF) >= 0x8000:
                newest = lap, place
        return divmod(newest[0] * self._size + newest[1] + 1, self._size)

    def rows(self) -> list[LogRow]:
        """Return what is told of it: of the newest lap, and of the one before it."""
        lap, place = self.end()
        end, size, found = lap % LAPS * self._size + place, self._size, []
        for number in range(end - size if end >= size else 0, end):
            lap, celsius, shall, does = self.whole().get(number % size, (-1, 0, 0, 0))
            if lap == number // size:
                shown = None if celsius == -0x8000 else celsius / 10
                found.append(LogRow(3600 * (number + 1) % 2**32, shown, shall / 10, does))
        return found


def images(bench: LogBoard, count: int = 60) -> None:
    chance, size = random.Random(1), bench.interface.entries  # noqa: S311 - no secret
    newest = [(0, 0), (0, 49), (0, 20), (0x2FF, 48), (0x300, 0), (0x7FFF, 49), (0x8000, 9),
              (LAPS - 2, 49), (LAPS - 1, 0), (LAPS - 1, 48), (LAPS - 1, 49)]  # fmt: skip
    newest += [(chance.randrange(LAPS), chance.randrange(size)) for _ in range(count)]
    for lap, last in newest:
        image = Image(bench)
        for place in range(size):
            # Laps in which it was passed over: 256 would leave their low byte as the next one's.
            passed = chance.randrange(0x70) * 0x100 + chance.randrange(1, 0xFF)
            of = lap - (place > last) - (chance.random() < 0.2) * passed
            image.put(of, place, struct.unpack("<hhB", chance.randbytes(5)))
            begins = image.start + SLOT * place
            if chance.random() < 0.2:  # cut short, or of another spec; no step to the next lap
                image.contents[begins + chance.choice((SLOT - 2, SLOT - 1))] ^= 0x55
            if chance.random() < 0.2:
                image.contents[begins : begins + SLOT] = SLOT * b"\xff"  # erased
        image.put(lap + 1, size, (7, 7, 7))
        _goes_through(bench.with_eeprom(bytes(image.contents)), image, chance)


def _goes_through(board: LogBoard, image: Image, chance: random.Random) -> None:
    """Read it; add entries, and cut the power meanwhile; add one while another is written, and
    clear it in the same way."""
    board.reads(1.5, 2.5, 3.5)
    for _ in range(2):
        before = image.rows()
        assert f"{board.rows()}" == f"{before}"
        image.put(*image.end(), (15, 25, 4))
        ticks = chance.randrange(20) / 2
        board.adds(ticks)
        after = board.with_eeprom(board.avr.eeprom.after_power_cut(chance.randrange(256)))
        # The oldest is given up when the newest begins to be written in its place.
        assert after.rows() in (before, before[1:], image.rows())
        found = Image(after)
        found.put(*found.end(), (35, 45, 6))
        after.reads(3.5, 4.5, 5.5)
        after.adds(10)
        assert after.rows() == found.rows()
        assert not after.avr.eeprom.violations, "the EEPROM was touched while it wrote"
        board.run((11 - ticks) * TICK_S)
        assert board.avr.eeprom.contents == image.contents
    lap, place = image.end()
    board.adds(4)
    image.contents[:] = board.avr.eeprom.contents
    board.adds(10)
    place += 1
    image.put(lap + place // board.interface.entries, place % board.interface.entries, (15, 25, 4))
    assert board.avr.eeprom.contents == image.contents, "an entry while another one is written"
    board.adds(4)
    image.contents[:] = board.avr.eeprom.contents
    for place in image.whole():
        image.contents[image.start + SLOT * (place + 1) - 1] ^= 0xFF
    board.ask("clear", 3 * TICK_S)
    board.adds(80)
    assert board.avr.eeprom.contents == image.contents, "cleared"
    assert not board.avr.eeprom.violations


def busy(bench: LogBoard) -> None:
    """The log does not wait for the EEPROM when ticks follow each other without a pause."""
    image = Image(bench)
    for place in range(bench.interface.entries):
        image.put(0, place, (place, place, place))
    bench = bench.with_eeprom(bytes(image.contents))
    profile = bench.avr.profile(bench.elf)
    bench.ask("log", SOON_S)
    usual = dict(profile.functions)
    bench.computer.write("log")
    for turn in range(10):
        bench.adds(0 if turn % 3 else 1)
        bench.put("deaf_ms", 35)
        bench.run(4 * TICK_S)
    for name in ("log_tick", "log_ring_tick"):
        more = profile.functions[name].longest - usual[name].longest
        assert more / bench.avr.clock_hz <= LONGEST_WAIT_S, name


def empty(bench: LogBoard) -> None:
    """A text is taken over with the port's interrupt off: one that came meanwhile would send a byte
    of neither."""
    bench.run(2 * TICK_S)
    bench.computer.write("help")
    sent, on, taken = 0, 0, 0
    for _ in range(50000):
        bench.avr.run(1e-6)
        before, was_on = sent, on
        sent, on = bench.get("log_port.c:sent"), bench.avr.read_ram(UCSR0B, 1)[0] & UDRIE0
        taken += sent < before
        assert sent >= before or not was_on
    assert taken


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
        (SLOW_RAM, commands),
        (EEPROM, commands),
        (SLOW_LINE, slow),
        (HOURLY, busy),
        (HOURLY, images),
        (SLOW_RAM, empty),
    ],
)
def test_it_stands(said: str, check: Callable[[LogBoard], None]) -> None:
    check(LogBoard(program(said)))
