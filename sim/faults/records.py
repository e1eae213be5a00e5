"""What happens to fault and heaters, to the cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.device import AvrDevice
from heatwright.sim.native.pins import Source, pin_number
from heatwright.sim.native.snapshots import Snapshots


@dataclass(frozen=True)
class Change:
    """The latched fault became another, or none (code 0), or came again: device time, s."""

    time_s: float
    code: int


class TripLog:
    """Each change of the latched fault, noted when the processor next goes to sleep.

    It goes to sleep within the tick in which the change was made; at start-up, before the first
    tick. A fault that is acknowledged and trips again within one tick shows in the count of
    acknowledgements, which lies beside its code.
    """

    def __init__(self, device: AvrDevice) -> None:
        self._device = device
        self._code = device.variables["fault.code"]
        self._count = device.variables["fault.acknowledgements"]
        if self._count.address != self._code.address + self._code.size:
            raise ValueError("The count of acknowledgements does not lie behind the fault's code.")
        self._snapshots: Snapshots | None = None
        self._start_s = 0.0
        self._changes: list[Change] = []

    def attach(self) -> None:
        """Record the processor that has just been powered on."""
        place = (self._code.address, self._code.size + self._count.size)
        self._start_s = self._device.time_s
        self._snapshots = self._device.avr.snapshots(place, place)

    def collect(self) -> None:
        """Take what has been recorded; to be done before the power goes."""
        if self._snapshots is None:
            return
        cycles, images = self._snapshots.take()
        for cycle, image in zip(cycles.tolist(), images.tolist(), strict=True):
            self._changes.append(
                Change(self._start_s + cycle / self._device.avr.clock_hz, image[0])
            )

    @property
    def changes(self) -> list[Change]:
        """All so far, in order."""
        self.collect()
        return self._changes

    def since(self, time_s: float) -> list[Change]:
        """Return the trips (not the acknowledgements) from a time on."""
        return [each for each in self.changes if each.time_s >= time_s and each.code]

    def acknowledged_s(self) -> float:
        """Return when a fault was last acknowledged; minus infinity before the first time."""
        ends = (after.time_s for before, after in pairwise(self.changes) if before.code)
        return max(ends, default=-math.inf)


@dataclass(frozen=True)
class Edge:
    """A heater's pin changed: device time (s), whether it is on, and whether by the processor."""

    pin: int
    time_s: float
    on: bool
    driven: bool


HEATER_EDGE = np.dtype([("pin", "u1"), ("time_s", "<f8"), ("on", "?"), ("driven", "?")])
"""An Edge; as a record, for there are some thousand a second of a heater's PWM."""


class HeaterLog:
    """Every change of these heaters' pins, also through resets and losses of power."""

    def __init__(self, device: AvrDevice, heaters: set[str]) -> None:
        self._device = device
        outputs = [device.outputs[name] for name in heaters]
        self._active = {pin_number(each.pin): each.active == "high" for each in outputs}
        self._edges = np.empty(0, HEATER_EDGE)
        self._fresh: list[NDArray[Any]] = []

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Take pin changes (PIN_EVENT records)."""
        del sent
        if not len(pins):
            return
        start_s = self._device.time_s - self._device.avr.time_s
        for pin, active in self._active.items():
            mine = pins[pins["pin"] == pin]
            if not len(mine):
                continue
            edges = np.empty(len(mine), HEATER_EDGE)
            edges["pin"] = pin
            edges["time_s"] = start_s + mine["cycle"] / self._device.avr.clock_hz
            edges["on"] = (mine["state"] & 1 == 1) == active
            edges["driven"] = mine["state"] >> 1 == Source.MCU
            self._fresh.append(edges)

    def power_cut(self) -> None:
        """The board's resistors pull every heater off."""
        self._device.feed()
        off = [(pin, self._device.time_s, False, False) for pin in self._active]
        self._fresh.append(np.array(off, HEATER_EDGE))

    def since(self, time_s: float) -> list[Edge]:
        """Return the changes from a time on (device time, s): each heater's in order of time."""
        edges = self._all()
        return [Edge(*edge.item()) for edge in edges[edges["time_s"] >= time_s]]

    def last_on_s(self, since_s: float) -> float | None:
        """Return when any heater was last on after a time (device time, s); None: never."""
        self._device.feed()
        ends = [end for pin in self._active if (end := self._last_end_s(pin)) > since_s]
        return max(ends, default=None)

    def _last_end_s(self, pin: int) -> float:
        """Return when a heater's last stretch of being on ended, or now; -inf: it never was on."""
        edges = self._all()
        mine = edges[edges["pin"] == pin]
        if len(mine) and mine["on"][-1]:
            return self._device.time_s
        ends = mine["time_s"][1:][mine["on"][:-1]]
        return float(ends[-1]) if len(ends) else -np.inf

    def _all(self) -> NDArray[Any]:
        if self._fresh:
            self._edges = np.concatenate([self._edges, *self._fresh])
            self._fresh = []
        return self._edges
