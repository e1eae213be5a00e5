"""A serial port of this computer with the simulated board at its other end."""

from __future__ import annotations

import os
import pty
import tty
from contextlib import suppress
from types import TracebackType
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.device import AvrDevice
from heatwright.sim.lines.serial_noise import SerialNoise
from heatwright.sim.native.characters import EIGHT_N_ONE, Format

READ_BYTES = 4096


class SerialPort:
    """A pseudo-terminal wired to a board's UART: any program can open it as a port.

    name -- such as /dev/pts/3. A context manager; at its end the port is gone.

    What the program sends goes to the board at the line's speed and in its format, which a
    pseudo-terminal does not know: a program opens it without parity. What the board says while
    nobody reads is lost, as on a cable. A simulated master or display leaves the line to the
    program. uart -- the number of the UART, that of the board's first interface if None.
    """

    def __init__(
        self,
        device: AvrDevice,
        baud: int,
        form: Format = EIGHT_N_ONE,
        *,
        noise: SerialNoise | None = None,
        uart: int | None = None,
    ) -> None:
        self._device = device
        self._number = device.uart if uart is None else uart
        self._baud, self._form = baud, form
        self._noise = noise or SerialNoise()
        self._board_end, self._program_end = pty.openpty()
        tty.setraw(self._program_end)
        os.set_blocking(self._board_end, False)
        self.name = os.ttyname(self._program_end)
        device.unplug()
        device.record(self)

    def __enter__(self) -> SerialPort:
        """Give itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the port."""
        os.close(self._board_end)
        os.close(self._program_end)

    def fileno(self) -> int:
        """Return what is readable when the program has written something."""
        return self._board_end

    def to_board(self) -> None:
        """Send the board what the program has written."""
        with suppress(BlockingIOError):
            data = os.read(self._board_end, READ_BYTES)
            uart = self._device.avr.uarts[self._number]
            uart.send(self._noise.to_board(data), self._baud, self._form)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Give the program what the board has sent (UART_BYTE records)."""
        del pins
        data = self._noise.to_host(sent["value"][sent["uart"] == self._number].tobytes())
        with suppress(BlockingIOError):
            while data:
                data = data[os.write(self._board_end, data) :]
