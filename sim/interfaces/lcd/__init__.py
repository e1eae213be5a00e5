"""A display on six lines, four of them data, decoded from a processor's pin log."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.interfaces.lcd.hd44780 import Hd44780
from heatwright.sim.native.pins import pin_number

_BLANK = (" " * 16, " " * 16)
_ENABLE = 0x20
_RS = 0x10
_DATA = 0x0F
_LONG_AGO = -(10.0**15)


@dataclass(frozen=True)
class BusLimits:
    """Minimum times of the bus, ns (data sheet, write operation).

    The default is the column for 2.7 to 4.5 V, stricter than the one for the shield's 5 V.
    """

    enable_cycle: int = 1000
    enable_width: int = 450
    address_setup: int = 60
    address_hold: int = 20
    data_setup: int = 195
    data_hold: int = 10


@dataclass(frozen=True)
class Screen:
    """The text that the display shows from a time on, s."""

    time_s: float
    rows: tuple[str, str]


class Lcd:
    """A display wired to six pins: RS, E, D4, D5, D6, D7, R/W grounded.

    chip -- the controller; history -- each change of its text, in order; violations -- how often
    the bus was too fast, by name of the limit; writes -- number of falls of E.
    """

    def __init__(self, pins: Sequence[str], clock_hz: int, limits: BusLimits | None = None) -> None:
        rs, enable, *data = pins
        self.pins = tuple(pins)
        self.chip = Hd44780()
        self.limits = limits or BusLimits()
        self.history: list[Screen] = [Screen(0.0, _BLANK)]
        self.violations: dict[str, int] = {}
        self.writes = 0
        self.plugged = True
        self._ns = 1e9 / clock_hz
        self._bits = np.zeros(256, np.int64)
        self._bits[pin_number(rs)], self._bits[pin_number(enable)] = _RS, _ENABLE
        self._bits[[pin_number(pin) for pin in data]] = 1, 2, 4, 8
        self._bus = 0
        self._last = {"rise": _LONG_AGO, "fall": _LONG_AGO, "rs": _LONG_AGO, "data": _LONG_AGO}

    @property
    def text(self) -> tuple[str, str]:
        """The two rows after the events fed so far."""
        return self.chip.text if self.plugged else _BLANK

    def unplug(self, time_s: float) -> None:
        """Disconnect the display; it goes dark and forgets everything."""
        self.plugged = False
        self._show(time_s * 1e9)

    def plug(self, time_s: float) -> None:
        """Plug the display in again: it starts again and must be initialised."""
        self.plugged = True
        self.chip.power_on(round(time_s * 1e9))
        self._show(time_s * 1e9)

    def feed(self, events: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT records) in order of time; other pins are ignored.

        A change in the same cycle as E counts as after E's fall and before E's rise, the worst case
        for hold and setup times.
        """
        if not len(events):
            return
        bits = self._bits[events["pin"]]
        mine = bits != 0
        if not mine.any():
            return
        bits, levels = bits[mine], (events["state"][mine] & 1).astype(bool)
        change = _changes(bits, levels, self._bus)
        cycles = events["cycle"][mine]
        order = np.lexsort((np.sign(change) * (bits == _ENABLE), cycles))
        change, times_ns = change[order], cycles[order] * self._ns
        bus = self._bus + np.cumsum(change)
        self._bus = int(bus[-1])
        self._judge(times_ns, change)
        falls = change == -_ENABLE
        self._latch(times_ns[falls], bus[falls])

    def _latch(self, times_ns: NDArray[np.float64], bus: NDArray[np.int64]) -> None:
        self.writes += len(bus)
        if not self.plugged:
            return
        for time_ns, lines in zip(times_ns.tolist(), bus.tolist(), strict=True):
            if self.chip.write(round(time_ns), lines & _RS, lines & _DATA):
                self._show(time_ns)

    def _show(self, time_ns: float) -> None:
        rows = self.text
        if rows != self.history[-1].rows:
            self.history.append(Screen(time_ns / 1e9, rows))

    def _judge(self, times_ns: NDArray[np.float64], change: NDArray[np.int64]) -> None:
        """Count the violations of the bus's time limits."""
        moves = {
            "rise": change == _ENABLE,
            "fall": change == -_ENABLE,
            "rs": abs(change) == _RS,
            "data": (change != 0) & (abs(change) <= 8),
        }
        before = {}
        for name, when in moves.items():
            latest = np.maximum.accumulate(np.where(when, times_ns, _LONG_AGO))
            latest = np.maximum(latest, self._last[name])
            before[name] = np.concatenate([[self._last[name]], latest[:-1]])
            self._last[name] = float(latest[-1])
        for limit, (move, since) in _RULES.items():
            gaps = (times_ns - before[since])[moves[move]]
            wrong = int((gaps < getattr(self.limits, limit)).sum())
            if wrong:
                self.violations[limit] = self.violations.get(limit, 0) + wrong


_RULES = {
    "enable_cycle": ("rise", "rise"),
    "enable_width": ("fall", "rise"),
    "address_setup": ("rise", "rs"),
    "address_hold": ("rs", "fall"),
    "data_setup": ("fall", "data"),
    "data_hold": ("data", "fall"),
}
"""Each limit is a least time: from the second kind of change to the first."""


def _changes(bits: NDArray[np.int64], levels: NDArray[np.bool_], bus: int) -> NDArray[np.int64]:
    """Return each event's change of the bus levels; 0 if only the source of a level has changed."""
    change = np.zeros(len(bits), np.int64)
    for bit in (1, 2, 4, 8, _RS, _ENABLE):
        mine = np.flatnonzero(bits == bit)
        if len(mine):
            now = levels[mine].astype(np.int64)
            change[mine] = bit * np.diff(now, prepend=bool(bus & bit))
    return change
