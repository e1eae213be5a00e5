"""A million random bytes and ten thousand malformed orders: nothing but the display's own changes.

Two boards run side by side, one of them with the bytes on its line. After every tick all of their
memory is compared; what only the display's own files may write is left out. The line goes at full
speed while a program runs.
"""

from collections.abc import Iterable

import pytest
from display_orders import Grammar, Malice
from kiln_desk import DISPLAY_FILES, RUNNING, Built
from memory_guard import Pair
from suite import amount

from heatwright.generator.stack import worst_stack
from heatwright.sim.avr import RAM_FILL
from heatwright.sim.device import AvrDevice

BAUD = 115_200
RANDOM_BYTES = amount("display_bytes")
MALFORMED = amount("display_orders")
SEED = 7
LONGEST = b"#7 8,10,100:9,10,200:10,10,100:;"
"""Makes the kiln's program as long as one may be: the next segment is beyond the array."""
STEP_S = 1.0
TICK_S = 0.01
FIRST_C, RISE_K_PER_S = 20.0, 0.15
"""What the thermocouple feels: as the program wants it, so that nothing trips."""


class Line:
    """Two boards, and whatever goes to the second."""

    def __init__(self, kiln: Built) -> None:
        self.kiln = kiln
        self.now_s = 0.0
        quiet, disturbed = (AvrDevice(*kiln) for _ in range(2))
        for device in (quiet, disturbed):
            device.unplug()
        self.pair = Pair(quiet, disturbed, DISPLAY_FILES)
        self.run(2.0)
        for device in (quiet, disturbed):
            device.avr.uarts[0].send(b"#8 1;" + LONGEST, BAUD)
        self.run(4.0)
        assert disturbed.read("program.state") == RUNNING

    @property
    def board(self) -> AvrDevice:
        """The one that is disturbed."""
        return self.pair.disturbed.device

    def run(self, seconds: float) -> None:
        """Let time pass, in steps; raises AssertionError for the first byte that differs."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.now_s += STEP_S
            for each in (self.pair.quiet, self.pair.disturbed):
                each.device.sense("chamber", FIRST_C + RISE_K_PER_S * self.now_s)
            self.pair.run_to(self.now_s)

    def send(self, chunks: Iterable[bytes], baud: float = BAUD) -> None:
        """Send all that comes, without a pause."""
        for data in chunks:
            self.board.avr.uarts[0].send(data, baud)
            self.run(10 * len(data) / baud)

    def finish(self) -> None:
        """See that all went well to the end: in time, on its stack, and that it still listens."""
        self.run(3.0)
        clock_hz = self.board.avr.clock_hz
        assert self.pair.latest / clock_hz < TICK_S / 2
        assert self.pair.disturbed.ticks == self.pair.quiet.ticks
        assert len(self.board.avr.take_resets()) == 0
        assert self.board.read("program.state") == RUNNING
        assert self.board.avr.eeprom.contents == self.pair.quiet.device.avr.eeprom.contents
        assert self.board.avr.stack_used <= worst_stack(self.kiln.program.path).total
        self.board.avr.uarts[0].send(b"#9 0;", BAUD)
        self.board.advance(self.now_s + 2.0)
        assert self.board.read("program.state") != RUNNING, "it listens no more"


@pytest.fixture
def line(kiln: Built) -> Line:
    return Line(kiln)


def sent_to(line: Line, name: str) -> None:
    """Send one of the things that a broken display sends, until its end."""
    malice = Malice(Grammar.of(line.kiln.controller), SEED)
    if name == "a line that is held low":
        line.board.avr.uarts[0].send_break(5.0)
        line.run(6.0)
        return
    baud = BAUD
    if name == "random bytes":
        data = malice.noise(RANDOM_BYTES)
    elif name == "malformed orders":
        data = b"".join(malice.orders(MALFORMED))
    elif name == "false answers":
        data = b"".join(malice.answers(MALFORMED))
    else:
        baud = int(name.removesuffix(" baud"))
        data = malice.noise(baud // 4)
    line.send((data[at : at + baud // 10] for at in range(0, len(data), baud // 10)), baud)


@pytest.mark.parametrize(
    "name",
    ["random bytes", "malformed orders", "false answers", "9600 baud", "57600 baud", "230400 baud",
     "a line that is held low"],
)  # fmt: skip
def test_nothing_but_the_displays_own_changes(line: Line, name: str) -> None:
    """False answers: pages that there are not, starts without end, errors."""
    sent_to(line, name)
    line.finish()


@pytest.mark.parametrize(
    "name", ["program.setpoint_c", "settings.chamber_kp", "fault.code", "PORTH", "OCR1A"]
)
def test_the_guard_sees_a_byte(line: Line, name: str) -> None:
    """Any one, in any variable that is not the display's own, and any register."""
    address = line.board.variables[name].address
    held = line.board.avr.read_ram(address, 1)
    line.board.avr.write_ram(address, bytes([held[0] ^ 1]))
    with pytest.raises(AssertionError, match=r"Difference|ticks are missing"):
        line.run(1.0)


def test_the_guard_sees_a_byte_below_the_stack(line: Line) -> None:
    """Nothing but the stack is ever written above the variables."""
    before = line.board.avr.stack_used
    address = line.board.elf.static_ram[1] + 40
    assert line.board.avr.read_ram(address, 1)[0] == RAM_FILL
    line.board.avr.write_ram(address, b"\0")
    assert line.board.avr.stack_used > worst_stack(line.kiln.program.path).total > before
