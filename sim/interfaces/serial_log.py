"""A computer that reads the log over a serial port, like a person at a terminal."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.native.characters import sent_by
from heatwright.spec import Board
from heatwright.spec import SerialLog as Spec
from heatwright.spec.board.uses import uart_of

HEADING = "time_s,temperature_c,setpoint_c,duty_percent"
PROGRAMMED = f"{HEADING},program,segment"
"""The columns of the log when programs set the loop's setpoint."""
MISMATCH = 0.045
"""Largest relative difference of two baud rates at which 8N1 is still received (half a bit in ten,
less the receiver's own sampling; ATmega328P data sheet, table 20-3: 4.5 %)."""
MOST_WAITING = 10_000
"""Maximum number of bytes that are kept of a line that never ends."""


@dataclass(frozen=True)
class LogRow:
    """An entry of the log.

    time_s -- since the log began; temperature_c -- None: there was no reading; program, segment --
    None: no program was under way.
    """

    time_s: int
    temperature_c: float | None
    setpoint_c: float
    duty_percent: int
    program: int | None = None
    segment: int | None = None


class SerialLog:
    """The computer at the end of a UART.

    lines -- the received lines, each with the time of its end, s; garbage -- bytes that came at
    another baud rate than the computer's.
    """

    complaints: tuple[str, ...] = ()

    def __init__(self, avr: Avr, baud: int, uart: int) -> None:
        self.lines: list[tuple[float, str]] = []
        self.garbage = 0
        self.baud = baud
        self._avr = avr
        self._uart = avr.uarts[uart]
        self._number = uart
        self._waiting = bytearray()

    def write(self, command: str) -> None:
        """Send a command and its line end; delete the lines received before."""
        self.lines.clear()
        self._waiting.clear()
        self.send_bytes(f"{command}\r\n".encode())

    def send_bytes(self, data: bytes) -> None:
        """Send these bytes."""
        self._uart.send(data, self.baud)

    @property
    def texts(self) -> list[str]:
        """The received lines, without their times."""
        return [text for _, text in self.lines]

    @property
    def is_complete(self) -> bool:
        """Whether the answer to `log` has ended with an empty line."""
        return bool(self.lines) and self.texts[-1] == ""

    @property
    def rows(self) -> list[LogRow]:
        """Parse the answer to `log`. Raises ValueError: it is no log."""
        heading, *rows = self.texts[:-1] if self.is_complete else self.texts
        if heading not in {HEADING, PROGRAMMED}:
            raise ValueError(f"A log does not begin with {heading!r}.")
        return [_row(text) for text in rows]

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Receive the bytes that the UARTs sent (UART_BYTE records)."""
        del pins
        mine = sent_by(self._number, sent)
        if not len(mine):
            return
        if abs(10 / (self._uart.frame_s * self.baud) - 1) > MISMATCH:
            self.garbage += len(mine)
            return
        for value, end in zip(mine["value"].tolist(), mine["end"].tolist(), strict=True):
            self._take(value, end / self._avr.clock_hz)

    def _take(self, byte: int, time_s: float) -> None:
        self._waiting.append(byte)
        del self._waiting[:-MOST_WAITING]
        if self._waiting.endswith(b"\r\n"):
            self.lines.append((time_s, self._waiting[:-2].decode("ascii", errors="replace")))
            self._waiting.clear()


def _row(text: str) -> LogRow:
    time_s, temperature_c, setpoint_c, duty, *place = text.split(",")
    return LogRow(
        int(time_s), float(temperature_c) if temperature_c else None, float(setpoint_c), int(duty),
        *(int(each) if each else None for each in place),
    )  # fmt: skip


def attach(avr: Avr, board: Board, interface: Spec) -> SerialLog:
    """Connect the computer to the interface's UART."""
    uart = uart_of(board, interface)
    assert uart is not None  # noqa: S101 - the checks have refused ports the board lacks
    return SerialLog(avr, interface.baud, uart.number)
