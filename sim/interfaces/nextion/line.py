"""The serial line of a simulated display, which receives at its own baud rate."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.native.characters import EIGHT_N_ONE, Format, heard, sent_by

LAST_SAMPLE = 9.5
"""Bit times from the edge of a start bit to the middle of the stop bit."""


class Line:
    """A UART of the board, seen from the display.

    garbage -- number of bytes from the board with a wrong stop bit; baud -- the display's own.
    """

    def __init__(self, avr: Avr, uart: int, baud: int) -> None:
        self.baud = baud
        self.garbage = 0
        self._avr = avr
        self._number = uart
        self._uart = avr.uarts[uart]
        self._coming: NDArray[Any] | None = None
        self._heard: NDArray[Any] | None = None

    def send(self, data: bytes) -> None:
        """Send bytes to the board, after those that wait."""
        if data:
            self._uart.send(data, self.baud)

    def cut(self) -> None:
        """Disconnect: waiting bytes are not sent, and a byte under way is not received."""
        self._uart.unsend()
        self._coming = None

    @property
    def has_news(self) -> bool:
        """Whether the board has sent anything since the last look."""
        return self._coming is not None or len(self._avr.uarts.log) > 0

    def hear(self, sent: NDArray[Any]) -> tuple[bytes, list[int]]:
        """Receive from the UARTs; return the bytes that have ended, and the cycle of each end."""
        if not len(sent) and self._coming is None:
            return b"", []
        mine = sent_by(self._number, sent)
        if self._coming is not None:
            mine = np.concatenate([self._coming, mine])
        ended = int(np.searchsorted(mine["end"], self._avr.cycle, "right"))
        self._coming = mine[ended:] if ended < len(mine) else None
        mine = self._heard = mine[:ended]
        if self._in_step(mine):
            return mine["value"].tobytes(), mine["end"].tolist()
        pairs = list(self._sampled(mine))
        return bytes(value for value, _ in pairs), [end for _, end in pairs]

    def change(self, baud: int, cycle: int) -> None:
        """Change the baud rate from a cycle on; bytes that ended after it are received again."""
        self.baud = baud
        if self._heard is not None:
            since = self._heard[self._heard["end"] > cycle]
            self._coming = since if self._coming is None else np.concatenate([since, self._coming])

    @property
    def _bit_cycles(self) -> float:
        return self._avr.clock_hz / self.baud

    def _in_step(self, mine: NDArray[Any]) -> bool:
        """Return whether every bit is sampled within its own time."""
        if not len(mine):
            return True
        late = (
            LAST_SAMPLE * (self._bit_cycles / each) for each in set(mine["bit_cycles"].tolist())
        )
        own = Format.of(int(mine["format"][0])) == EIGHT_N_ONE
        return own and all(9 <= each < 10 for each in late)

    def _sampled(self, mine: NDArray[Any]) -> Iterator[tuple[int, int]]:
        for record in mine:
            value, right = heard(record, EIGHT_N_ONE, self._bit_cycles)
            if right:
                yield value, int(record["end"])
            else:
                self.garbage += 1
