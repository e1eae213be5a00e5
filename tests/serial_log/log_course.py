"""What the log must say in any case, tried on a board: the whole one, and broken ones."""

from functools import cache

from log_firmware import TICK_S, LogBoard, program

from heatwright.sim.avr import RAM_FILL
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.serial_log import HEADING, LogRow
from heatwright.spec.eeprom import layout

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

    def problem(self, when: str) -> str:
        """Read the log; say what is not as it should be."""
        texts = self.ask("log")
        due = self.rows[-self.bench.interface.entries :]
        if texts[:1] != [HEADING] or texts[-1] or len(texts) != len(due) + 2:
            return (
                f"{when}: {len(texts)} lines from {texts[:1]} to {texts[-1:]}, not {len(due) + 2}"
            )
        found = self.bench.computer.rows
        wrong = [pair for pair in zip(found, due, strict=True) if pair[0] != pair[1]]
        return f"{when}: {wrong[0][0]}, not {wrong[0][1]}" if wrong else ""


def shown_c(celsius: float) -> float:
    """Round to what an entry holds: tenths, halves away from zero, within its 16 bits."""
    tenths = min(int(abs(celsius) * 10 + 0.5), 32767)
    return -tenths / 10 if celsius < 0 else tenths / 10


def course_problem(bench: LogBoard, laps: int = 6) -> str:
    """Say what is wrong with notes, so many laps of them, and their reading; empty if nothing."""
    notes, entries = Notes(bench), bench.interface.entries
    if problem := notes.problem("nothing noted"):
        return problem
    for celsius, setpoint_c in (
        (21.04, 20.0), (-0.04, 0.0), (-0.06, -0.05), (-250.05, 1000.0), (None, 9.96),
        (1372.04, 99.95), (5000.0, 4000.0), (-5000.0, -4000.0), (100.0, 0.5),
    ):  # fmt: skip
        notes.go(celsius, setpoint_c)
    if problem := notes.problem("a few"):
        return problem
    for number in range(laps * entries + 7):
        notes.go(20.0 + number, 1000.0 - number)
        if number in {entries - 10, entries - 9, entries - 8, entries, laps * entries + 6}:
            problem = problem or notes.problem(f"{number} more")
    return problem or _cleared_problem(notes)


def _cleared_problem(notes: Notes) -> str:
    notes.go(1.0)
    if notes.ask("clear") != ["cleared"]:
        return "not cleared"
    notes.begin_anew()
    if problem := notes.problem("cleared"):
        return problem
    notes.wait(50.0)  # an entry that came by the time before it was cleared would have this
    notes.go(2.0)
    notes.go(3.0)
    return notes.problem("after it was cleared")


def no_reading_problem(bench: LogBoard) -> str:
    """Say whether a temperature is told before there was one."""
    notes = Notes(bench)
    bench.reads(7.0)
    bench.put("loop_air.has_reading", 0)
    bench.run(notes.every_s)
    texts = notes.ask("log")
    return "" if texts == [HEADING, f"{notes.every_s},,20.0", ""] else f"{texts}"


def commands_problem(bench: LogBoard) -> str:
    """Say what is wrong with how commands are heard; empty if nothing."""
    notes = Notes(bench)
    notes.go(5.0)
    row = [HEADING, f"{notes.every_s},5.0,20.0", ""]
    for sent, due in (
        (b"help\n", HELP),
        (b"help\r\n", HELP),
        (b"\r\n\n\r", []),
        (b"log\r", row),
        (b"logs\n", UNKNOWN),
        (b"lo\n", UNKNOWN),
        (b"helphelp\n", UNKNOWN),
        (b"helphelphelp\n", UNKNOWN),
        (b"helphelphelphelp\nlog\n", UNKNOWN + row),
        (b"a" * 250 + b"\nlog\n", UNKNOWN + row),
        (b"x\nhelp\n", UNKNOWN + HELP),
        (b"log\nhelp\n", [HEADING, *HELP]),
        (b"\0help\n", UNKNOWN),
        (b"he\0lp\nlog\n", UNKNOWN + row),
        (b"log\0\n", UNKNOWN),
    ):
        bench.computer.lines.clear()
        bench.computer.send_bytes(sent, gap_s=TICK_S / 20)
        bench.run(0.4)
        if bench.computer.texts != due:
            return f"{sent!r} is answered {bench.computer.texts}"
    return _damaged_problem(bench, row)


def _damaged_problem(bench: LogBoard, row: list[str]) -> str:
    """Damage bits, and send more than is taken in a tick."""
    bench.computer.lines.clear()
    stop_bit = [0, 1 << 9, 0, 0]
    bench.avr.uarts[0].send(b"log\n", bench.computer.baud, gap_s=TICK_S / 20, flips=stop_bit)
    bench.run(0.4)
    if bench.computer.texts != UNKNOWN:
        return f"a damaged line is answered {bench.computer.texts}"
    bench.computer.lines.clear()
    bench.computer.send_bytes(b"log" + b"\n" * 40)  # too many for its receiver, in one tick
    bench.run(0.4)
    bench.computer.send_bytes(b"\n")
    bench.run(0.4)
    if UNKNOWN[0] not in bench.computer.texts:
        return f"lost bytes are answered {bench.computer.texts}"
    bench.computer.lines.clear()
    bench.computer.send_bytes(b"log\n", gap_s=TICK_S)
    bench.run(0.4)
    if bench.computer.texts != row:
        return f"then {bench.computer.texts}"
    behind = bench.avr.read_ram(bench.elf.static_ram[1], GUARDED)
    return "" if set(behind) == {RAM_FILL} else "something is written behind all variables"


def slow_problem(elf: Elf | None = None) -> str:
    """Say what is wrong with a line that is so slow that the ring goes on while it is read."""
    bench = LogBoard(program(SLOW_LINE), elf)
    notes = Notes(bench)
    for number in range(25):
        notes.go(float(number))
    bench.computer.write("log")
    bench.run(60.0)
    if bench.computer.texts[:1] != [HEADING]:
        return f"{bench.computer.texts}"
    rows = bench.computer.rows
    times = [row.time_s for row in rows]
    if times != list(range(6, times[-1] + 1)) or times[-1] < 27 or bench.computer.texts[-1]:
        return f"{times}, then {bench.computer.texts[-1]!r}"
    wrong = [row for row in rows if row.time_s <= 25 and row.temperature_c != row.time_s - 1]
    return f"{wrong}" if wrong else ""


def kept_problem(elf: Elf | None = None, each: int = 1) -> str:
    """Cut the power at each (or every so many) moments of writing: the log goes on behind it."""
    bench = LogBoard(program(EEPROM), elf)
    notes = Notes(bench)
    for number in range(53):
        notes.go(float(number))
    bench.run(notes.every_s - WRITTEN_S - 2 * TICK_S)
    for cut in range(30):
        bench.reads(99.0, 98.0)
        bench.run(TICK_S / 2 if cut else TICK_S)
        for undefined in (0x00, 0xFF, 0x35) if cut % each == 0 else ():
            if problem := _cut_problem(bench, notes.rows, undefined):
                return f"cut {cut}, {undefined:#x}: {problem}"
    return _forgotten_problem(bench)


def _cut_problem(bench: LogBoard, rows: list[LogRow], undefined: int) -> str:
    after = bench.after_power_cut(undefined)
    every_s = round(bench.interface.every_s)
    if after.ask("log", SOON_S)[:1] != [HEADING]:
        return "no answer"
    held = after.computer.rows
    new = LogRow(every_s * 54, 99.0, 98.0)
    # The oldest is given up when the newest begins to be written in its place.
    if held not in (rows[-50:], rows[-49:], [*rows[-49:], new]):
        return f"{len(held)} rows from {held[:1]} to {held[-1:]}"
    after.reads(1.0)
    after.run(every_s + WRITTEN_S)
    after.ask("log", SOON_S)
    last = LogRow(every_s * (55 if new in held else 54), 1.0, 20.0)
    if after.avr.eeprom.violations:
        return "the EEPROM was touched while it wrote"
    return "" if after.computer.rows[-1] == last else f"{after.computer.rows[-1]}, not {last}"


def _forgotten_problem(bench: LogBoard) -> str:
    """What was cleared does not come back, and what is of another spec or lap is no entry."""
    bench.ask("clear", SOON_S)
    after = bench.after_power_cut()
    if after.ask("log", SOON_S) != [HEADING, ""]:
        return "what was cleared has come back"
    other = LogBoard(program(EEPROM), bench.elf, full(OTHER_SPEC))
    if other.ask("log", SOON_S) != [HEADING, ""]:
        return "entries of another spec"
    image = bytearray(full(EEPROM))
    start = layout(bench.controller).history.start
    for place in (start + 8 * 3, start + 8 * 3 + 7):
        image[place] -= 1
    other = LogBoard(program(EEPROM), bench.elf, bytes(image))
    other.ask("log", SOON_S)
    return "" if len(other.computer.rows) == 49 else "an entry of another lap"


@cache
def full(said: str) -> bytes:
    """Return the EEPROM of a sound board, its log full."""
    notes = Notes(LogBoard(program(said)))
    for number in range(60):
        notes.go(float(number))
    return notes.bench.avr.eeprom.contents


def busy_problem(elf: Elf | None = None) -> str:
    """Say whether the log waits for the EEPROM when ticks follow each other without a pause."""
    bench = LogBoard(program(EEPROM), elf, full(EEPROM))
    profile = bench.avr.profile(bench.elf)
    bench.ask("log", SOON_S)
    usual = profile.functions["log_tick"].longest
    bench.run(bench.interface.every_s - SOON_S - 3 * TICK_S)
    bench.computer.write("log")
    for _ in range(10):
        bench.put("deaf_ms", 35)
        bench.run(4 * TICK_S)
    wait_s = (profile.functions["log_tick"].longest - usual) / bench.avr.clock_hz
    return "" if wait_s <= LONGEST_WAIT_S else f"a wait of {wait_s * 1e6:.0f} us"
