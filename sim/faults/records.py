"""Record when the latched fault and the heaters' pins change, to the cycle."""

import math
from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.device import AvrDevice
from heatwright.sim.native.hw import Log
from heatwright.sim.native.pins import Source, pin_number


@dataclass(frozen=True)
class Change:
    """A trip or an acknowledgement (code 0) at a device time, s."""

    time_s: float
    code: int


class TripLog:
    """Each change of the latched fault, recorded when the processor next goes to sleep.

    It sleeps within the tick of the change or, at start-up, before the first tick. A fault that is
    acknowledged and trips again within one tick is seen by the count of acknowledgements, which
    lies behind the fault's code in the RAM.
    """

    def __init__(self, device: AvrDevice) -> None:
        self._device = device
        self._code = device.variables["fault.code"]
        self._count = device.variables["fault.acknowledgements"]
        if self._count.address != self._code.address + self._code.size:
            raise ValueError("fault.acknowledgements does not follow fault.code in the RAM.")
        self._snapshots: Log | None = None
        self._start_s = 0.0
        self._changes: list[Change] = []

    def attach(self) -> None:
        """Record the processor that has just been powered on."""
        place = (self._code.address, self._code.size + self._count.size)
        self._start_s = self._device.time_s
        self._snapshots = self._device.avr.snapshots(place, place)

    def collect(self) -> None:
        """Fetch what has been recorded; call it before each power cut."""
        if self._snapshots is None:
            return
        taken = self._snapshots.take()
        for cycle, image in zip(taken["cycle"].tolist(), taken["image"].tolist(), strict=True):
            time_s = self._start_s + cycle / self._device.avr.clock_hz
            self._changes.append(Change(time_s, image[0]))

    @property
    def changes(self) -> list[Change]:
        """All changes so far, in order of time."""
        self.collect()
        return self._changes

    def forget(self) -> None:
        """Delete all changes so far."""
        self.collect()
        self._changes.clear()

    def since(self, time_s: float) -> list[Change]:
        """Return the trips (not the acknowledgements) from a device time (s) on."""
        return [each for each in self.changes if each.time_s >= time_s and each.code]

    def acknowledged_s(self) -> float:
        """Return when a fault was last acknowledged (device time, s); minus infinity: never."""
        ends = (after.time_s for before, after in pairwise(self.changes) if before.code)
        return max(ends, default=-math.inf)


@dataclass(frozen=True)
class Edge:
    """A change of a heater's pin: device time (s), on or off, driven by the processor or not."""

    pin: int
    time_s: float
    on: bool
    driven: bool


RECENT_S = 60.0
"""How long single edges are kept: a heater's PWM makes some thousand a second."""


class HeaterLog:
    """Records when these heaters' pins were on, through resets and losses of power.

    first_on_s -- when one of them was first on since power-on (device time, s); None: none was.
    """

    def __init__(self, device: AvrDevice, heaters: set[str]) -> None:
        self._device = device
        device.log_edges(heaters)
        outputs = [device.outputs[name] for name in heaters]
        self._active = {pin_number(each.pin): each.active == "high" for each in outputs}
        self._on = dict.fromkeys(self._active, False)
        self._last_end_s = dict.fromkeys(self._active, -math.inf)
        self.first_on_s: float | None = None
        self._recent: deque[tuple[float, NDArray[Any]]] = deque()

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT records)."""
        del sent
        if not len(pins):
            return
        start_s, clock_hz = self._device.powered_s, self._device.avr.clock_hz
        for pin, active in self._active.items():
            mine = pins[pins["pin"] == pin]
            if not len(mine):
                continue
            on = (mine["state"] & 1 == 1) == active
            was_on = np.concatenate(([self._on[pin]], on[:-1]))
            if was_on.any():
                end = mine["cycle"][len(mine) - 1 - int(np.argmax(was_on[::-1]))]
                self._last_end_s[pin] = start_s + int(end) / clock_hz
            if on.any():
                first_s = start_s + int(mine["cycle"][np.argmax(on)]) / clock_hz
                self.first_on_s = min(first_s, self.first_on_s or first_s)
            self._on[pin] = bool(on[-1])
            self._recent.append((start_s, mine))
        old_s = self._device.time_s - RECENT_S
        while self._recent and self._ends_s(*self._recent[0]) < old_s:
            self._recent.popleft()

    def _ends_s(self, start_s: float, edges: NDArray[Any]) -> float:
        return start_s + int(edges["cycle"][-1]) / self._device.avr.clock_hz

    def power_cut(self) -> None:
        """Record all pins as off: without power, the board's resistors pull them off."""
        self._device.feed()
        for pin, on in self._on.items():
            if on:
                self._last_end_s[pin] = self._device.time_s
        self._on = dict.fromkeys(self._active, False)
        self.first_on_s = None

    def since(self, time_s: float) -> list[Edge]:
        """Return the changes since a recent time (device time, s), in order for each heater."""
        found = []
        for start_s, mine in self._recent:
            edges_s = start_s + mine["cycle"] / self._device.avr.clock_hz
            late = np.flatnonzero(edges_s >= time_s)
            for edge_s, edge in zip(edges_s[late].tolist(), mine[late], strict=True):
                pin, state = int(edge["pin"]), int(edge["state"])
                on = bool(state & 1) == self._active[pin]
                found.append(Edge(pin, edge_s, on, state >> 1 == Source.MCU))
        return found

    def last_on_s(self, since_s: float) -> float | None:
        """Return when a heater was last on, if after `since_s` (device time, s); otherwise None."""
        self._device.feed()
        last_s = max(self._last_end_s.values())
        if any(self._on.values()):
            last_s = self._device.time_s
        return last_s if last_s > since_s else None
