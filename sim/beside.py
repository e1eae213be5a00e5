"""A run on the bench with a binary: plant and processor advance together in C, many rows a call."""

import math
from typing import Any

import numpy as np

from heatwright.sim.bench import PROGRESS_REPORTS, Progress, Run
from heatwright.sim.device import AvrDevice
from heatwright.sim.machine import FEED, TIPS, Machine
from heatwright.sim.plants.thermal_network import Plant


class RunBeside(Run):
    """One run, in stretches between the operator's actions."""

    def __init__(self, *parts: Any) -> None:
        """Take the same arguments as Run."""
        super().__init__(*parts)
        assert isinstance(self._device, AvrDevice)  # noqa: S101 - only binaries run here
        assert isinstance(self._plant, Plant)  # noqa: S101 - the only kind of plant
        self._machine = Machine(
            self._plant, self._device, self._coupling, self._step_s, logs_nodes=True
        )

    def go(self, progress: Progress | None) -> None:
        """Run to the end."""
        report_every = max(1, self._count // PROGRESS_REPORTS)
        self._note(0, self._felt())
        row = 0
        while row < self._count:
            calm = min(self._calm_rows(row), report_every, self._count - row)
            if calm > 0:
                self._machine.go(calm)
            else:
                self._machine.by_hand(self._advance)
            row += max(1, calm)
            if progress is not None:
                progress(row * self._step_s, self._count * self._step_s)
        self._take(self._machine)

    def _calm_rows(self, row: int) -> int:
        """Return the number of next rows without an action of the operator, or one less."""
        if self._done == len(self._hand):
            return self._count
        return math.floor(self._hand[self._done].time_s / self._step_s) - row - 1

    def _take(self, machine: Machine) -> None:
        """Copy the machine's log: sensor inputs are from before a row, the rest from after it."""
        rows = machine.rows
        felt = np.vstack((rows[:, TIPS : TIPS + len(machine.sensors)], machine.felt))
        self._sensed, self._amperes = np.split(felt, [len(self._sensors)], axis=1)
        self._temperatures[1:] = machine.nodes_c(rows)
        self._active[1:] = machine.given(rows)
        self._fed[1:] = rows[:, FEED]
