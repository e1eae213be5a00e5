"""A simulated board behind a serial port, in a process of its own, so that a host here is free."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from heatwright.sim.device import AvrDevice
from heatwright.sim.live import Clock, run
from heatwright.sim.serial_noise import SerialNoise
from heatwright.sim.serial_port import SerialPort
from heatwright.spec import Controller

BAUD = 115200


@dataclass(frozen=True)
class Noise:
    """What SerialNoise is made of."""

    to_board_share: float = 0.0
    to_host_share: float = 0.0
    seed: int = 0


class _Watched:
    """Answers questions about the board between two exchanges."""

    def __init__(self, port: SerialPort, device: AvrDevice, noise: SerialNoise, pipe: Any) -> None:
        self._port, self._device, self._noise, self._pipe = port, device, noise, pipe

    def to_board(self) -> None:
        """Exchange bytes, and answer."""
        self._port.to_board()
        while self._pipe.poll():
            name = self._pipe.recv()
            if name == "steps":
                self._pipe.send(self._device.steps("nozzle"))
            elif name == "hits":
                self._pipe.send(self._noise.hits)
            elif name == "said":
                self._pipe.send([line.text for line in self._device.host.lines])
            elif name == "cut":
                felt_c = self._device.read("loop_nozzle.temperature_c")
                self._device.power_cycle()
                self._device.sense("nozzle", felt_c)
                self._pipe.send(None)
            else:
                self._pipe.send(self._device.read(name).item())


def _live(controller: Controller, elf: Path, speed: float, noise: Noise, pipe: Connection) -> None:
    device = AvrDevice(controller, elf)
    disturbed = SerialNoise(
        to_board_share=noise.to_board_share, to_host_share=noise.to_host_share, seed=noise.seed
    )
    with SerialPort(device, BAUD, noise=disturbed) as port:
        pipe.send(port.name)
        run(controller, device, _Watched(port, device, disturbed, pipe), Clock(speed))


class LiveBoard:
    """The board as a test sees it: port -- where a host finds it."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self.port: str = pipe.recv()

    def ask(self, what: str) -> Any:
        """Return a variable by its name, "steps" so far, what was "said" before the noise,
        the noise's "hits"; or "cut" the power and give it back.
        """
        self._pipe.send(what)
        return self._pipe.recv()


@contextmanager
def live_board(
    controller: Controller, elf: Path, speed: float, noise: Noise | None = None
) -> Iterator[LiveBoard]:
    """Run a board so many times faster than real time, until the end of the context."""
    context = multiprocessing.get_context("forkserver")
    ours, theirs = context.Pipe()
    process = context.Process(
        target=_live, args=(controller, elf, speed, noise or Noise(), theirs), daemon=True
    )
    process.start()
    try:
        yield LiveBoard(ours)
    finally:
        process.terminate()
        process.join()
