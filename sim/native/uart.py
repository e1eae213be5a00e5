"""Serial lines of a simulated processor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.log import Log

UART_BYTE = np.dtype(
    {
        "names": ["written", "end", "uart", "value", "lost"],
        "formats": ["<u8", "<u8", "u1", "u1", "?"],
        "itemsize": 24,
    }
)
"""A byte sent: the cycle it was written to UDR, the cycle its last stop bit ends, which UART, its
value, and whether it was lost because transmitter and buffer were full."""

BITS_8N1 = 10


class Uart:
    """One UART, 8N1 on the side of the host."""

    def __init__(self, hw: Hw, number: int) -> None:
        self._lib, self._hw, self._clock_hz = hw.lib, hw.pointer, hw.clock_hz
        self._number = number

    def send(self, data: bytes, baud: float) -> None:
        """Send bytes to the processor back to back, after those still waiting."""
        frame = self._clock_hz / baud * BITS_8N1
        self._lib.hw_uart_send(self._hw, self._number, data, len(data), frame)

    @property
    def unsent(self) -> int:
        """Bytes that still wait to be sent to the processor."""
        return int(self._lib.hw_uart_unsent(self._hw, self._number))

    def unsend(self) -> None:
        """Forget the bytes that still wait."""
        self._lib.hw_uart_unsend(self._hw, self._number)

    @property
    def frame_s(self) -> float:
        """Length of a frame as the firmware has set it, start to stop bit, s."""
        return float(self._lib.hw_uart_frame_cycles(self._hw, self._number)) / self._clock_hz

    @property
    def overruns(self) -> int:
        """Bytes the firmware wrote while transmitter and buffer were full: lost."""
        return int(self._lib.hw_uart_overruns(self._hw, self._number))


class Uarts:
    """All UARTs; what they send shares one log."""

    def __init__(self, hw: Hw) -> None:
        self._hw = hw
        self.log = Log(hw, hw.lib.HW_UART_LOG, UART_BYTE)

    def __getitem__(self, number: int) -> Uart:
        return Uart(self._hw, number)

    def take(self) -> NDArray[Any]:
        """Return what was sent since the last call (UART_BYTE records)."""
        return self.log.take()
