"""A computer that receives lines for the program Serial Port Plotter: ``$1.00 2.00;``."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.serial_log import MISMATCH
from heatwright.sim.native.characters import sent_by
from heatwright.spec import Board
from heatwright.spec import SerialPlotter as Spec

ENDS = {"LF": b"\n", "CR LF": b"\r\n"}


def line_of(decimals: int) -> re.Pattern[bytes]:
    """Return the pattern of a line whose numbers have this number of decimals."""
    number = rb"-?\d+" + (rb"\.\d{%d}" % decimals if decimals else b"")
    return re.compile(rb"\$(%b(?: %b)*);" % (number, number))


@dataclass(frozen=True)
class PlotterLine:
    """A line, and the time of its last character, s."""

    time_s: float
    values: tuple[float, ...]


class SerialPlotter:
    """The computer at the end of a UART.

    lines -- the lines that were correct; ended -- number of lines that came right after a correct
    `line_end` (a reset may cut one off); garbage -- number of bytes that belonged to no line; baud
    -- its baud rate, with which the firmware's is compared.
    """

    def __init__(
        self, avr: Avr, baud: int, uart: int = 0, decimals: int = 2, line_end: str = "LF"
    ) -> None:
        self.lines: list[PlotterLine] = []
        self.ended = 0
        self.garbage = 0
        self.baud = baud
        self._avr = avr
        self._uart = uart
        self._form = line_of(decimals)
        self._end = ENDS[line_end]
        self._waiting = bytearray()

    @property
    def speed_error(self) -> float:
        """Relative difference of the firmware's baud rate from the computer's."""
        return 10 / (self._avr.uarts[self._uart].frame_s * self.baud) - 1

    @property
    def complaints(self) -> Iterator[str]:
        """Yield a complaint about bytes that belonged to no line."""
        if self.garbage:
            yield f"serial plotter: {self.garbage} bytes belong to no line"

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Receive the bytes that the UARTs sent (UART_BYTE records)."""
        del pins
        mine = sent_by(self._uart, sent)
        if not len(mine):
            return
        if abs(self.speed_error) > MISMATCH:
            self.garbage += len(mine)
            return
        start = 0
        text = mine["value"].tobytes()
        while (end := text.find(b";", start) + 1) > 0:
            self._waiting += text[start:end]
            self._line(int(mine["end"][end - 1]) / self._avr.clock_hz)
            start = end
        self._waiting += text[start:]

    def _line(self, time_s: float) -> None:
        received = bytes(self._waiting)
        text = received.removeprefix(self._end)
        self._waiting.clear()
        self.ended += len(text) < len(received)
        found = self._form.fullmatch(text)
        if found is None:
            self.garbage += len(text)
            return
        values = tuple(float(field) for field in found.group(1).split())
        self.lines.append(PlotterLine(time_s, values))


def attach(avr: Avr, board: Board, interface: Spec) -> SerialPlotter:
    """Connect the computer to the board's first UART."""
    form = interface.decimals, interface.line_end
    return SerialPlotter(avr, interface.baud, board.uarts[0].number, *form)
