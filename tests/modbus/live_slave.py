"""A simulated slave behind a serial port, in a process of its own, whose clock waits for us."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_rtu import format_of
from heatwright.sim.live import Clock, run
from heatwright.sim.serial_port import SerialPort
from heatwright.spec import Controller, modbus_of

BUSY_S = 0.2
"""So long the slave runs on after a byte has come: its answer is out by then."""


class _Patient(Clock):
    """A clock that stands while nothing is asked: a busy computer does not change what happens."""

    def __init__(self, port: SerialPort, device: AvrDevice, pipe: Connection) -> None:
        super().__init__(1.0)
        self._port, self._device, self._pipe = port, device, pipe
        self._until_s = 0.0
        self._running = False

    def to_board(self) -> None:
        """Send the board what has come, and let it run on for that."""
        if wait([self._port], 0):
            self._until_s = max(self._until_s, self._device.time_s + BUSY_S)
            self._port.to_board()

    def wait(self, board_s: float) -> None:
        """Go on while there is something to do; what is asked is answered when there is not."""
        while board_s >= self._until_s:
            if self._running:
                self._running = False
                self._pipe.send(None)
            if self._port in wait([self._port, self._pipe]):  # what came before a question
                return
            self._answer(self._pipe.recv(), board_s)

    def _answer(self, asked: str | float, board_s: float) -> None:
        if isinstance(asked, float):
            self._until_s, self._running = board_s + asked, True
        elif asked == "resets":
            self._pipe.send(len(self._device.avr.take_resets()))
        else:
            self._pipe.send(self._device.read(asked).item())


def _live(controller: Controller, elf: Path, pipe: Connection) -> None:
    interface = modbus_of(controller)
    assert interface is not None
    device = AvrDevice(controller, elf)
    with SerialPort(device, interface.baud, format_of(interface)) as port:
        pipe.send(port.name)
        patient = _Patient(port, device, pipe)
        run(controller, device, patient, patient)


class LiveSlave:
    """The slave as a test sees it: port -- where a master finds it."""

    def __init__(self, pipe: Any) -> None:
        self._pipe = pipe
        self.port: str = pipe.recv()

    def ask(self, what: str) -> Any:
        """Return a variable by its name, or the number of "resets"."""
        self._pipe.send(what)
        return self._pipe.recv()

    def run(self, seconds: float) -> None:
        """Let it run on for a time of its own, s."""
        self._pipe.send(seconds)
        self._pipe.recv()


@contextmanager
def live_slave(controller: Controller, elf: Path) -> Iterator[LiveSlave]:
    """Run a slave until the end of the context."""
    context = multiprocessing.get_context("forkserver")
    ours, theirs = context.Pipe()
    process = context.Process(target=_live, args=(controller, elf, theirs), daemon=True)
    process.start()
    try:
        yield LiveSlave(ours)
    finally:
        process.kill()
        process.join()
