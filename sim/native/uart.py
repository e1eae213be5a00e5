"""Serial lines of a simulated processor."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.characters import EIGHT_N_ONE, UART_BYTE, Format, characters
from heatwright.sim.native.hw import Hw, Log


class Uart:
    """One UART, and the line to its receiver."""

    def __init__(self, hw: Hw, number: int) -> None:
        self._lib, self._ffi, self._hw = hw.lib, hw.ffi, hw.pointer
        self._clock_hz = hw.clock_hz
        self._number = number

    def send(
        self,
        data: bytes,
        baud: float,
        form: Format = EIGHT_N_ONE,
        *,
        gap_s: float | Sequence[float] = 0.0,
        flips: Sequence[int] = (),
    ) -> None:
        """Send bytes to the processor, after those still waiting.

        gap_s -- silence before each, or one number for all, s; flips -- for each byte the bits of
        its character that a disturbance inverts, the start bit lowest.
        """
        gaps = np.asarray(gap_s, np.float64) * self._clock_hz
        self._put(characters(data, form, self._clock_hz / baud, gaps, flips))

    def send_break(self, seconds: float) -> None:
        """Hold the line low for a time, s, after the bytes still waiting."""
        made = characters(b"\0", EIGHT_N_ONE, seconds * self._clock_hz, np.zeros(1), ())
        made["levels"], made["bits"] = 0, 1
        self._put(made)

    def _put(self, made: NDArray[Any]) -> None:
        raw = self._ffi.from_buffer("hw_uart_character[]", made)
        self._lib.hw_uart_send(self._hw, self._number, raw, len(made))

    @property
    def unsent(self) -> int:
        """Number of characters to the processor that have not begun yet."""
        return int(self._lib.hw_uart_unsent(self._hw, self._number))

    def unsend(self) -> None:
        """Drop the characters to the processor that have not begun yet."""
        self._lib.hw_uart_unsend(self._hw, self._number)

    @property
    def frame_s(self) -> float:
        """Duration of a character with the firmware's settings, from start to stop bit, s."""
        return float(self._lib.hw_uart_frame_cycles(self._hw, self._number)) / self._clock_hz

    @property
    def overruns(self) -> int:
        """Number of bytes lost: the firmware wrote them while transmitter and buffer were full."""
        return int(self._lib.hw_uart_overruns(self._hw, self._number))


class Uarts:
    """All UARTs; what they send shares one log."""

    def __init__(self, hw: Hw) -> None:
        self._hw = hw
        self.log = Log(hw, hw.lib.HW_UART_LOG, UART_BYTE)

    def __getitem__(self, number: int) -> Uart:
        """Return a UART by number; IndexError if the processor does not have it."""
        if not self._hw.lib.hw_uart_exists(self._hw.pointer, number):
            raise IndexError(f"This processor has no UART {number}")
        return Uart(self._hw, number)

    def take(self) -> NDArray[Any]:
        """Return the bytes sent since the last call (UART_BYTE records)."""
        return self.log.take()
