"""A G-code host: it sends numbered lines with checksums, one after each `ok`.

After its first line it polls the temperatures when it has sent nothing else for POLL_S.
"""

import re
from collections import deque
from dataclasses import dataclass
from functools import reduce
from operator import xor
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.lines.serial_noise import SerialNoise
from heatwright.sim.native.characters import sent_by
from heatwright.spec import Board
from heatwright.spec import Gcode as Spec

RESEND = re.compile(r"(?:Resend|rs)\D*(\d+)", re.IGNORECASE)
TEMPERATURE = re.compile(r"T:(-?\d+\.?\d*) /(-?\d+\.?\d*)")
REFUSED = re.compile(r"echo:.*(nothing was changed$| refused: |Unknown command|Invalid )")
TALK_S = 0.02
"""How often the host reads answers while it is busy: the board answers within this time."""
POLL_S = 5.0
"""Time between two polls, as with OctoPrint and Printrun."""
MOST_WAITING = 10_000
"""Maximum number of bytes that are kept of a line that never ends."""


@dataclass(frozen=True)
class HostLine:
    """A line and its time, s: of its last character if from the board, or when it was sent."""

    time_s: float
    text: str


@dataclass(frozen=True)
class HostTemperature:
    """The active tool's temperatures in a report of the board."""

    time_s: float
    temperature_c: float
    setpoint_c: float


def heats(address: str) -> str:
    """Return the command that sets the target of a loop by its host address, such as `M104 T0`."""
    return {"B": "M140", "C": "M141"}.get(address, f"M104 {address}")


def tunes(address: str) -> str:
    """Return the command that tunes a loop's gains, such as `M303 T0`."""
    return {"B": "M303 E-1", "C": "M303 E-2"}.get(address, f"M303 {address}")


def numbered(number: int, line: str) -> str:
    """Return a line with number and checksum: the exclusive or of all bytes before the star."""
    text = f"N{number} {line}"
    return f"{text}*{reduce(xor, text.encode(), 0)}"


class GcodeHost:
    """The host at the end of a UART.

    lines -- lines from the board; sent -- lines to it, with their times; resends -- how often the
    board asked for a line again. numbers -- whether it numbers its lines, as hosts do while they
    print.
    """

    complaints: tuple[str, ...] = ()

    def __init__(self, avr: Avr, baud: int, uart: int = 0) -> None:
        self.lines: list[HostLine] = []
        self.sent: list[HostLine] = []
        self.resends = 0
        self.numbers = True
        self.noise: SerialNoise | None = None
        self.baud = baud
        self._avr = avr
        self._uart = avr.uarts[uart]
        self._number = uart
        self._queue: deque[str] = deque()
        self._history: list[str] = []
        self._next = 0
        self._awaits_ok = False
        self._waiting = bytearray()
        self._poll_cycle: int | None = None
        self._plugged = True

    # -- operation -----------------------------------------------------------------------------

    def send(self, line: str) -> None:
        """Send a line once the lines before it are answered; does nothing while unplugged."""
        if not self._plugged:
            return
        self._poll_cycle = self._avr.cycle + round(POLL_S * self._avr.clock_hz)
        if self.numbers and not self._history and not self._queue:
            self._queue.append("M110 N0")
        self._queue.append(line)
        self._go_on()

    def send_bytes(self, data: bytes) -> None:
        """Send these bytes at once."""
        if self.noise is not None:
            data = self.noise.to_board(data)
        self._uart.send(data, self.baud)

    def unsend(self) -> None:
        """Drop the bytes to the board whose start bit has not been sent yet."""
        self._uart.unsend()

    def unplug(self) -> None:
        """Unplug the host: it sends nothing more, not even waiting lines."""
        self._plugged, self._poll_cycle, self._awaits_ok = False, None, False
        self._queue.clear()
        self._next = len(self._history)

    def plug(self) -> None:
        """Plug the host in again; it polls again after its next line."""
        self._plugged = True

    @property
    def is_busy(self) -> bool:
        """Whether it still has lines to send, or waits for an answer."""
        return self._awaits_ok or bool(self._queue) or self._next < len(self._history)

    @property
    def wake_cycle(self) -> int | None:
        """The cycle of its next read or poll; None before its first line, or while unplugged."""
        if self.is_busy:
            return self._avr.cycle + round(TALK_S * self._avr.clock_hz)
        return None if self._poll_cycle is None else max(self._avr.cycle, self._poll_cycle)

    def texts(self, start: str = "") -> list[str]:
        """Return the lines that begin with `start`."""
        return [line.text for line in self.lines if line.text.startswith(start)]

    @property
    def refusals(self) -> list[HostLine]:
        """Return the lines in which the board refuses a command."""
        return [line for line in self.lines if REFUSED.match(line.text)]

    @property
    def temperatures(self) -> list[HostTemperature]:
        """Return the temperatures of the active tool that the board has reported."""
        return [
            HostTemperature(line.time_s, float(found[1]), float(found[2]))
            for line in self.lines
            if (found := TEMPERATURE.search(line.text))
        ]

    # -- the line ------------------------------------------------------------------------------

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Receive the bytes that the UARTs sent (UART_BYTE records)."""
        del pins
        mine = sent_by(self._number, sent)
        for value, end in zip(mine["value"].tolist(), mine["end"].tolist(), strict=True):
            data = bytes([value]) if self.noise is None else self.noise.to_host(bytes([value]))
            for byte in data:
                self._take(byte, end / self._avr.clock_hz)
        due_cycle = self._poll_cycle
        if due_cycle is not None and self._avr.cycle >= due_cycle and not self.is_busy:
            self.send("M105")

    def _take(self, byte: int, time_s: float) -> None:
        if byte != ord("\n"):
            self._waiting.append(byte)
            del self._waiting[:-MOST_WAITING]
            return
        text = self._waiting.decode("ascii", errors="replace").rstrip("\r")
        self._waiting.clear()
        self.lines.append(HostLine(time_s, text))
        self._react(text)

    def _react(self, text: str) -> None:
        if found := RESEND.match(text):
            self.resends += 1
            wanted = int(found[1])
            if wanted <= len(self._history):
                self._next = max(0, wanted - 1)
        elif text == "start":
            self._awaits_ok = False  # the board was reset: no answer will come
        elif text == "ok" or text.startswith("ok "):
            self._awaits_ok = False
        self._go_on()

    def _go_on(self) -> None:
        if self._awaits_ok:
            return
        if self._next < len(self._history):
            self._write(numbered(self._next + 1, self._history[self._next]))
            self._next += 1
        elif self._queue:
            self._write(self._fresh(self._queue.popleft()))

    def _fresh(self, line: str) -> str:
        if not self.numbers:
            return line
        if line == "M110 N0":
            return numbered(0, line)
        self._history.append(line)
        self._next = len(self._history)
        return numbered(self._next, line)

    def _write(self, text: str) -> None:
        self._awaits_ok = True
        self.sent.append(HostLine(self._avr.time_s, text))
        self.send_bytes(text.encode() + b"\n")


def attach(avr: Avr, board: Board, interface: Spec) -> GcodeHost:
    """Connect the host to the board's first UART."""
    return GcodeHost(avr, interface.baud, board.uarts[0].number)
