"""Whatever becomes of the display, and whatever it sends: nothing but the display's own changes.

Two kilns run a program side by side, one of them with the bytes on its line, at full speed. After
every tick all of RAM, the registers included, must be the same in both but for what is named; and
nothing is ever written between the variables and the stack.
"""

import re
from collections.abc import Iterable

import numpy as np
import pytest
from display_model import Grammar, Malice
from numpy.typing import NDArray
from rig.firmware import began_s, example, sources_of, whole
from suite import amount
from test_kiln_touched import RUNNING

from heatwright.generator.stack import worst_stack
from heatwright.sim.avr import RAM_FILL
from heatwright.sim.binary.dwarf import Variable
from heatwright.sim.device import AvrDevice

DISPLAY_FILES = sorted(name for name in sources_of("kiln") if re.fullmatch(r"nextion\w*\.c", name))
"""Source files whose variables are the display's own."""
FIRST = 0x20  # address of the first register; below are those of the core
CORE = slice(0x5D - FIRST, 0x60 - FIRST)  # stack pointer and status register
HASTY = re.compile(r"TCNT\d|UDR\d|UCSR\d[ABC]|UBRR\d[HL]?|TIFR\d|PIN[A-L]|EEAR|EEDR")
"""Registers that tell the very moment, those of the line, and where the EEPROM was read last."""
TICK = "clock.c:ticks_of_second"  # Changes once a tick, in the main loop
BAUD = 115_200
LONGEST = b"#7 8,10,100:9,10,200:10,10,100:;"
"""Makes the kiln's program as long as one may be: the next segment is beyond the array."""
STEP_S = 1.0
TICK_S = 0.01
FIRST_C, RISE_K_PER_S = 20.0, 0.15
"""What the thermocouple feels: as the program wants it, so that nothing trips."""


class Watched(AvrDevice):
    """A kiln whose memory is noted each time it falls asleep after a tick."""

    def __init__(self) -> None:
        super().__init__(example("kiln").controller, whole("kiln"))
        self.unplug()
        end = self.elf.static_ram[1]
        self.images = self.avr.snapshots((self.variables[TICK].address, 1), (FIRST, end - FIRST))
        self._same = np.ones(end - FIRST, bool)
        self._same[CORE] = False
        for each in self._free():
            self._same[each.address - FIRST :][: each.size] = False

    def _free(self) -> list[Variable]:
        registers = [each for each in self.variables.of_file("") if HASTY.fullmatch(each.name)]
        return registers + [each for file in DISPLAY_FILES for each in self.variables.of_file(file)]

    def differences(self, mine: NDArray[np.uint8], others: NDArray[np.uint8]) -> list[str]:
        places = np.nonzero(((mine != others) & self._same).any(axis=0))[0]
        return [self._name(FIRST + int(place)) for place in places[:5]]

    def _name(self, address: int) -> str:
        for name in self.variables:  # type: ignore[attr-defined]
            found = self.variables[name]
            if found.address <= address < found.address + found.size:
                return str(name)
        return f"0x{address:04x}"


class Kilns:
    """Two kilns that run a program; board -- the one that is disturbed; stack_bytes -- at most."""

    def __init__(self) -> None:
        self.now_s = began_s("kiln") + TICK_S / 2  # what is late stays on its side of a step's end
        self.quiet, self.board = Watched(), Watched()
        self.stack_bytes = worst_stack(self.board.elf.path).total
        self._latest_cycles = 0
        self.run(2.0)
        for each in (self.quiet, self.board):
            each.avr.uarts[0].send(b"#8 1;" + LONGEST, BAUD)
        self.run(4.0)
        assert self.board.read("program.state") == RUNNING

    def run(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.now_s += STEP_S
            for each in (self.quiet, self.board):
                each.sense("chamber", FIRST_C + RISE_K_PER_S * self.now_s)
                each.advance(self.now_s)
                each.feed()
            quiet, disturbed = self.quiet.images.take(), self.board.images.take()
            assert len(quiet) == len(disturbed), f"ticks are missing before {self.now_s} s"
            found = self.board.differences(disturbed["image"], quiet["image"])
            assert not found, f"difference within {STEP_S} s before {self.now_s} s: {found}"
            late = disturbed["cycle"].astype(np.int64) - quiet["cycle"].astype(np.int64)
            self._latest_cycles = max(self._latest_cycles, int(late.max()))

    def send(self, chunks: Iterable[bytes], baud: float = BAUD) -> None:
        for data in chunks:
            self.board.avr.uarts[0].send(data, baud)
            self.run(10 * len(data) / baud)

    def finish(self) -> None:
        """See that all went well to the end: in time, on its stack, and that it still listens."""
        self.run(3.0)
        avr = self.board.avr
        assert self._latest_cycles / avr.clock_hz < TICK_S / 2
        assert len(self.board.take_resets()) == 0
        assert self.board.read("program.state") == RUNNING
        assert avr.eeprom.contents == self.quiet.avr.eeprom.contents
        assert avr.stack_used <= self.stack_bytes
        avr.uarts[0].send(b"#9 0;", BAUD)
        self.board.advance(self.now_s + 2.0)
        assert self.board.read("program.state") != RUNNING, "it listens no more"


# -- what is sent

SEED = 7
TOUCHES = ("bset", "back", "bdebug", "back", "bprog", "b1", "back", "bfaults", "back")


@pytest.fixture
def kilns() -> Kilns:
    return Kilns()


@pytest.mark.parametrize(
    "name", ["random bytes", "malformed orders", "false answers", "9600", "57600", "230400"]
)
def test_nothing_but_the_displays_own_changes(kilns: Kilns, name: str) -> None:
    """False answers: pages that there are not, starts without end, errors; and other speeds."""
    malice, baud = Malice(Grammar(example("kiln").controller), SEED), BAUD
    if name == "random bytes":
        data = malice.noise(amount("display_bytes"))
    elif name == "malformed orders":
        data = b"".join(malice.orders(amount("display_orders")))
    elif name == "false answers":
        data = b"".join(malice.answers(amount("display_orders")))
    else:
        baud = int(name)
        data = malice.noise(baud // 4)
    kilns.send((data[at : at + baud // 10] for at in range(0, len(data), baud // 10)), baud)
    kilns.finish()


def test_a_line_that_is_held_low_changes_nothing(kilns: Kilns) -> None:
    kilns.board.avr.uarts[0].send_break(5.0)
    kilns.run(6.0)
    kilns.finish()


def test_a_display_that_comes_and_goes_and_is_touched_changes_nothing(kilns: Kilns) -> None:
    """The quiet one has none."""
    display = kilns.board.display
    assert display.instructions == 0, "it has heard what it was not there for"
    for seconds in (1.0, 2.0, 3.0, 30.0):
        display.plug()
        kilns.run(seconds)
        display.unplug()
        kilns.run(1.0)
    display.plug()
    kilns.run(2.0)
    for name in 4 * TOUCHES:
        display.tap(name)
        kilns.run(1.0)
    assert display.page == "main"
    kilns.finish()


@pytest.mark.parametrize(
    "name", ["program.setpoint_c", "settings.chamber_kp", "fault.code", "PORTH", "OCR1B"]
)
def test_the_guard_sees_a_byte(kilns: Kilns, name: str) -> None:
    """Any one, in any variable that is not the display's own, and any register."""
    address = kilns.board.variables[name].address
    held = kilns.board.avr.read_ram(address, 1)
    kilns.board.avr.write_ram(address, bytes([held[0] ^ 1]))
    with pytest.raises(AssertionError, match=r"difference|ticks are missing"):
        kilns.run(1.0)


def test_the_guard_sees_a_byte_below_the_stack(kilns: Kilns) -> None:
    """Nothing but the stack is ever written above the variables."""
    avr = kilns.board.avr
    before = avr.stack_used
    address = kilns.board.elf.static_ram[1] + 40
    assert avr.read_ram(address, 1)[0] == RAM_FILL
    avr.write_ram(address, b"\0")
    assert avr.stack_used > kilns.stack_bytes > before
