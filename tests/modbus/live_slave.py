"""A simulated slave behind a serial port, in a process of its own."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_rtu import format_of
from heatwright.sim.live import Clock, run
from heatwright.sim.serial_port import SerialPort
from heatwright.spec import Controller, modbus_of


class _Watched:
    """Answers questions about the slave between two exchanges."""

    def __init__(self, port: SerialPort, device: AvrDevice, pipe: Connection) -> None:
        self._port, self._device, self._pipe = port, device, pipe

    def to_board(self) -> None:
        """Exchange bytes, and answer."""
        self._port.to_board()
        while self._pipe.poll():
            name = self._pipe.recv()
            if name == "resets":
                self._pipe.send(len(self._device.avr.take_resets()))
            else:
                self._pipe.send(self._device.read(name).item())


def _live(controller: Controller, elf: Path, speed: float, pipe: Connection) -> None:
    interface = modbus_of(controller)
    assert interface is not None
    device = AvrDevice(controller, elf)
    with SerialPort(device, interface.baud, format_of(interface)) as port:
        pipe.send(port.name)
        run(controller, device, _Watched(port, device, pipe), Clock(speed))


class LiveSlave:
    """The slave as a test sees it: port -- where a master finds it."""

    def __init__(self, pipe: Any) -> None:
        self._pipe = pipe
        self.port: str = pipe.recv()

    def ask(self, what: str) -> Any:
        """Return a variable by its name, or the number of "resets"."""
        self._pipe.send(what)
        return self._pipe.recv()


@contextmanager
def live_slave(controller: Controller, elf: Path, speed: float) -> Iterator[LiveSlave]:
    """Run a slave so many times faster than real time, until the end of the context."""
    context = multiprocessing.get_context("forkserver")
    ours, theirs = context.Pipe()
    process = context.Process(target=_live, args=(controller, elf, speed, theirs), daemon=True)
    process.start()
    try:
        yield LiveSlave(ours)
    finally:
        process.kill()
        process.join()
