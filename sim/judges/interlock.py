"""Check at the pins that heater and cooler of a loop are never on together."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.pins import pin_number
from heatwright.sim.outputs.switch import Switch


class Interlock:
    """Compares the pins of a loop's heater and cooler, cycle by cycle."""

    def __init__(self, heater: Switch, cooler: Switch, clock_hz: int) -> None:
        self._pins = tuple(pin_number(switch.pin) for switch in (heater, cooler))
        self._active = tuple(int(switch.active == "high") for switch in (heater, cooler))
        self._clock_hz = clock_hz
        self._overlap_s: float | None = None
        self.power_on(0.0)

    def power_on(self, start_s: float) -> None:
        """Begin with both off, at a device time, s."""
        self._start_s = start_s
        self._on = [False, False]
        self._since = 0

    @property
    def overlap_s(self) -> float | None:
        """When both were first on together (device time, s); None: never."""
        if self._overlap_s is None and all(self._on):
            return self._start_s + self._since / self._clock_hz
        return self._overlap_s

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT records)."""
        del sent
        if not len(pins):
            return
        heater, cooler = self._pins
        mine = pins[(pins["pin"] == heater) | (pins["pin"] == cooler)]
        if not len(mine):
            return
        cycles = np.concatenate(([self._since], mine["cycle"].astype(np.int64)))
        heats, cools = (self._levels(mine, which) for which in (0, 1))
        lengths = np.where(heats & cools, np.diff(cycles, append=cycles[-1]), 0)
        if self._overlap_s is None and lengths.any():
            self._overlap_s = self._start_s + int(cycles[np.argmax(lengths > 0)]) / self._clock_hz
        self._since = int(cycles[-1])

    def _levels(self, mine: NDArray[Any], which: int) -> NDArray[np.bool_]:
        """Return one pin's on-states: after the last change before these events, and after each."""
        own = mine["pin"] == self._pins[which]
        latest = np.maximum.accumulate(np.where(own, np.arange(1, len(mine) + 1), 0))
        on = np.concatenate(([self._on[which]], (mine["state"] & 1) == self._active[which]))
        self._on[which] = bool(on[latest[-1]])
        return on[np.concatenate(([0], latest))]


def overlaps(watches: Mapping[str, Interlock]) -> Iterator[str]:
    """Yield each loop whose heater and cooler were on together, with the time."""
    for loop, watch in watches.items():
        if watch.overlap_s is not None:
            yield f"{loop}: heater and cooler were on together at {watch.overlap_s:.6f} s"
