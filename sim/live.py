"""Run a board and its machine in real time, or at a multiple of it."""

from collections.abc import Callable
from math import ceil
from time import monotonic, sleep
from typing import Protocol

from heatwright.sim.bench import step_of
from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice
from heatwright.sim.plants import plant_of
from heatwright.spec import Controller

EXCHANGE_S = 0.005
"""How often bytes are exchanged with outside programs, in the board's time, s."""
MOST_BEHIND_S = 0.5
"""Longest delay, in real time, that is made up for; a longer one is not."""
LEAST_SLEEP_S = 0.001


class Line(Protocol):
    """A connection of an outside program to the board."""

    def to_board(self) -> None:
        """Send the bytes from outside to the board."""


class Clock:
    """Keeps the board's time in step with real time.

    speed -- seconds of the board per real second; time, pause -- replaced in a test.
    """

    def __init__(
        self,
        speed: float,
        time: Callable[[], float] = monotonic,
        pause: Callable[[float], None] = sleep,
    ) -> None:
        self._speed, self._time, self._pause = speed, time, pause
        self._start_s = time()

    def wait(self, board_s: float) -> None:
        """Wait for the real time of a board time; if it is long past, count from now on."""
        early_s = self._start_s + board_s / self._speed - self._time()
        if early_s > LEAST_SLEEP_S:
            self._pause(early_s)
        elif early_s < -MOST_BEHIND_S:
            self._start_s -= early_s


def run(
    controller: Controller,
    device: AvrDevice,
    line: Line,
    clock: Clock,
    *,
    until_s: float | None = None,
) -> None:
    """Run the board against the spec's machine, to a time or without end.

    Raises ValueError: the spec has no simulation.
    """
    simulation = controller.simulated
    step_s = step_of(controller)
    exchanges = ceil(step_s / EXCHANGE_S)
    plant = plant_of(
        controller, simulation.plant, ambient_c=simulation.ambient_c, step_s=step_s, seed=0
    )
    coupling = Coupling(controller, device, step_s)
    row = 0
    while until_s is None or row * step_s < until_s:
        for sensor, felt in (plant.sensed_c() | plant.currents_a()).items():
            device.sense(sensor, felt)
        for part in range(1, exchanges + 1):
            time_s = (row + part / exchanges) * step_s
            line.to_board()
            device.advance(time_s)
            device.feed()
            clock.wait(time_s)
        plant.step(coupling.supplied(coupling.active()), coupling.feed_mm_per_s())
        row += 1
