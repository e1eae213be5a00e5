"""RAM images taken while a program runs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.hw import Hw, Range
from heatwright.sim.native.log import Log


class Snapshots:
    """RAM images, one for each change of a counter."""

    def __init__(self, log: Log) -> None:
        self._log = log

    def __len__(self) -> int:
        return len(self._log)

    def take(self) -> tuple[NDArray[np.uint64], NDArray[np.uint8]]:
        """Return cycles, and images (one per row), since the last call."""
        records = self._log.take()
        return records["cycle"], records["image"]


def snapshots(hw: Hw, counter: Range, ram: Range) -> tuple[Snapshots, Log]:
    """Start recording; see Avr.snapshots."""
    number = hw.lib.hw_snapshot(hw.pointer, *counter, *ram)
    if number < 0:
        raise ValueError("There are too many snapshots, or their range is not in RAM.")
    log = Log(hw, number, np.dtype([("cycle", "<u8"), ("image", "u1", (ram[1],))]))
    return Snapshots(log), log
