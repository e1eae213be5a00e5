"""A serial port of this computer, connected to the simulated board."""

from __future__ import annotations

import os
import pty
import tty
from contextlib import suppress
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.device import AvrDevice
from heatwright.sim.lines.serial_noise import SerialNoise
from heatwright.sim.native.characters import EIGHT_N_ONE, Format

READ_BYTES = 4096


class SerialPort:
    """A pseudo-terminal wired to a board's UART: any program can open it as a port.

    name -- such as /dev/pts/3. A context manager; the port exists until its end.

    The program's bytes go to the board at the line's baud rate and in its format. A pseudo-terminal
    has no parity: the program opens it without. Bytes from the board are lost while the program
    does not read, as on a cable. A simulated master or display is disconnected from the line.
    uart -- the number of the UART; None: that of the board's first interface.
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
        """Return the port itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the port."""
        os.close(self._board_end)
        os.close(self._program_end)

    def fileno(self) -> int:
        """Return the file descriptor that becomes readable when the program has written."""
        return self._board_end

    def to_board(self) -> None:
        """Send the program's bytes to the board."""
        with suppress(BlockingIOError):
            data = os.read(self._board_end, READ_BYTES)
            uart = self._device.avr.uarts[self._number]
            uart.send(self._noise.to_board(data), self._baud, self._form)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Send the board's bytes to the program (UART_BYTE records)."""
        del pins
        data = self._noise.to_host(sent["value"][sent["uart"] == self._number].tobytes())
        with suppress(BlockingIOError):
            while data:
                data = data[os.write(self._board_end, data) :]
