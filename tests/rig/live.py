"""A simulated board behind a serial port, in a process of its own, so that a host here is free. And
a serial line of this computer, with something at its other end."""

import json
import multiprocessing
import os
import pty
import signal
import subprocess
import sys
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Event, Thread
from typing import Any

from rig.firmware import EXAMPLES, controller_of, whole

from heatwright.sim.circuits import Wiring
from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.indicators import Indicators
from heatwright.sim.lines.serial_noise import SerialNoise
from heatwright.sim.lines.serial_port import SerialPort
from heatwright.sim.live import Clock, run
from heatwright.sim.native.characters import EIGHT_N_ONE, Format
from heatwright.sim.sensors.adc_sensor import AdcSensor
from heatwright.spec import Controller

BUSY_S = 0.2  # so long a patient board runs on after a byte has come: its answer is out by then


@dataclass(frozen=True)
class Cable:
    """How a host is connected.

    speed -- the board's seconds in one of ours. Without one its clock stands while nothing is
    asked: a busy computer does not change what happens.
    """

    baud: int
    form: Format = EIGHT_N_ONE
    speed: float | None = None
    to_board_share: float = 0.0
    to_host_share: float = 0.0
    spares: bytes | None = None
    seed: int = 0


class _Watched(Clock):
    """Exchanges bytes, keeps the time, and answers questions about the board meanwhile."""

    def __init__(
        self, controller: Controller, cable: Cable, device: AvrDevice, pipe: Connection
    ) -> None:
        super().__init__(cable.speed or 1.0)
        self._noise = SerialNoise(
            to_board_share=cable.to_board_share,
            to_host_share=cable.to_host_share,
            spares=cable.spares,
            seed=cable.seed,
        )
        self._loops, self._device, self._pipe = controller.loops, device, pipe
        self.port = SerialPort(device, cable.baud, cable.form, noise=self._noise)
        self._patient = cable.speed is None
        self._until_s = 0.0
        self._running = False

    def to_board(self) -> None:
        """Send the board what has come, and let it run on for that."""
        if wait([self.port], 0):
            self._until_s = max(self._until_s, self._device.time_s + BUSY_S)
            self.port.to_board()
        while not self._patient and self._pipe.poll():
            self._answer(self._pipe.recv())

    def wait(self, board_s: float) -> None:
        """Wait for the wall; or go on while there is something to do, and answer when not."""
        if not self._patient:
            super().wait(board_s)
        while self._patient and board_s >= self._until_s:
            if self._running:
                self._running = False
                self._pipe.send(None)
            if self.port in wait([self.port, self._pipe]):  # what came before a question
                return
            asked = self._pipe.recv()
            if isinstance(asked, float):
                self._until_s, self._running = board_s + asked, True
            else:
                self._answer(asked)

    def _answer(self, asked: str) -> None:
        device = self._device
        known = {
            "steps": lambda: device.steps(next(iter(self._loops))),
            "hits": lambda: self._noise.hits,
            "said": lambda: [line.text for line in device.host.lines], "lights": self._lights,
            "resets": lambda: len(device.avr.take_resets()), "cut": self._cut,
            "noise": lambda: self._disturb(on=True), "quiet": lambda: self._disturb(on=False),
            "torn": lambda: self._wire(Wiring(opened=True)), "sound": lambda: self._wire(Wiring()),
        }  # fmt: skip
        self._pipe.send(known.get(asked, lambda: device.read(asked).item())())

    def _lights(self) -> dict[str, str]:
        (leds,) = (each for each in self._device.interfaces if isinstance(each, Indicators))
        return dict(leds.lights())

    def _disturb(self, *, on: bool) -> None:
        self._noise.is_on = on

    def _wire(self, wiring: Wiring) -> None:
        for sensor in self._device.sensors.values():
            assert isinstance(sensor, AdcSensor)
            sensor.wiring = wiring

    def _cut(self) -> None:
        """Lose the power for a moment; the machine stays as warm as it is."""
        felt_c = {
            loop.sensor: self._device.read(f"loop_{name}.temperature_c")
            for name, loop in self._loops.items()
        }
        self._device.power_cycle()
        for sensor, degrees in felt_c.items():
            self._device.sense(sensor, degrees)


def _live(spec: str, cable: Cable, pipe: Connection) -> None:
    controller = controller_of(spec)
    device = AvrDevice(controller, whole(spec))
    watched = _Watched(controller, cable, device, pipe)
    with watched.port as port:
        pipe.send(port.name)
        run(controller, device, watched, watched)


class LiveBoard:
    """The board as a test sees it: port -- where a host finds it."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self.port: str = pipe.recv()

    def ask(self, what: str) -> Any:
        """Return a variable by its name, the "steps" so far, what was "said" before the noise, the
        noise's "hits", the number of "resets", the LEDs' "lights"; or "cut" the power and give it
        back, let there be "noise" or "quiet", let all sensors be "torn" off or "sound"."""
        self._pipe.send(what)
        return self._pipe.recv()

    def run(self, seconds: float) -> None:
        """Let a patient board run on for a time of its own, s."""
        self._pipe.send(seconds)
        self._pipe.recv()


@contextmanager
def live_board(spec: str, cable: Cable) -> Iterator[LiveBoard]:
    """Run the board of a spec (its text, or the name of an example) until the context's end."""
    whole(spec)
    context = multiprocessing.get_context("forkserver")
    ours, theirs = context.Pipe()
    process = context.Process(target=_live, args=(spec, cable, theirs), daemon=True)
    process.start()
    try:
        yield LiveBoard(ours)
    finally:
        process.kill()
        process.join()


HEATWRIGHT = Path(sys.executable).parent / "heatwright"


@contextmanager
def simulated(name: str, speed: float) -> Iterator[tuple[str, int]]:
    """The port and the baud rate that `heatwright simulate --serial` tells, until Ctrl-C."""
    command = [HEATWRIGHT, "simulate", EXAMPLES / f"{name}.yaml", "--serial", "--json"]
    command += ["--speed", str(speed)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            told = json.loads("".join(process.stdout.readline() for _ in range(5)))
            assert told["speed"] == speed
            port = Path(told["port"])
            made_ns = port.stat().st_ctime_ns
            yield told["port"], told["baud"]
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
    with suppress(FileNotFoundError):  # it is gone; another test may have one of its name by now
        assert port.stat().st_ctime_ns != made_ns


@contextmanager
def answered(turn: Callable[[int, Event], None]) -> Iterator[str]:
    """A line's name; at its other end a turn comes after the other, in a thread, until the end.

    turn -- is given the other end, which does not block, and what is set when all is over.
    """
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    done = Event()

    def run() -> None:
        while not done.is_set():
            turn(ours, done)

    thread = Thread(target=run)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        done.set()
        thread.join()
        os.close(ours)
        os.close(theirs)


def wait_for(
    done: Callable[[], object], told: Callable[[], object], most_s: float, every_s: float = 0.05
) -> None:
    """Wait until something is so, in real time; told -- what is said if it does not come."""
    end_s = time.monotonic() + most_s
    while not done():
        assert time.monotonic() < end_s, told()
        time.sleep(every_s)
