"""The six lines of a display on four data lines, read from a processor's pin log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.interfaces.hd44780 import Hd44780
from heatwright.sim.native.pins import pin_number

_BLANK = (" " * 16, " " * 16)
_E = 0x20
_RS = 0x10
_DATA = 0x0F


@dataclass(frozen=True)
class BusLimits:
    """Least times of the bus, ns (data sheet, write operation).

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
    """What the display shows from a time on, s."""

    time_s: float
    rows: tuple[str, str]


class Lcd:
    """A display wired to six pins: RS, E, D4, D5, D6, D7, R/W grounded.

    chip -- the controller; history -- each change of what it shows, in order; violations -- how
    often the bus was too fast, by name of the limit; writes -- falls of E seen.
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
        self._bits = {pin_number(rs): _RS, pin_number(enable): _E}
        self._bits |= {pin_number(pin): 1 << place for place, pin in enumerate(data)}
        self._bus = 0
        self._rose = self._fell = self._data_changed = self._rs_changed = -1e12

    @property
    def text(self) -> tuple[str, str]:
        """The two rows as of the events fed so far."""
        return self.chip.text if self.plugged else _BLANK

    def unplug(self, time_s: float) -> None:
        """Take the display off; it goes dark and forgets everything."""
        self.plugged = False
        self._show(time_s * 1e9)

    def plug(self, time_s: float) -> None:
        """Put it back: it starts anew and has to be initialised."""
        self.plugged = True
        self.chip.power_on(round(time_s * 1e9))
        self._show(time_s * 1e9)

    def feed(self, events: NDArray[Any]) -> None:
        """Take pin changes (PIN_EVENT records) in order of time; other pins' are passed over."""
        known, ns = self._bits, self._ns
        for cycle, pin, state in zip(
            events["cycle"].tolist(), events["pin"].tolist(), events["state"].tolist(), strict=True
        ):
            bit = known.get(pin)
            if bit is None:
                continue
            bus = self._bus | bit if state & 1 else self._bus & ~bit
            if bus != self._bus:
                self._bus = bus
                self._change(cycle * ns, bit)

    def _change(self, time_ns: float, bit: int) -> None:
        if bit == _E:
            self._enable(time_ns, bool(self._bus & _E))
            return
        if bit == _RS:
            self._rs_changed = time_ns
            self._check("address_hold", time_ns - self._fell)
        else:
            self._data_changed = time_ns
            self._check("data_hold", time_ns - self._fell)

    def _enable(self, time_ns: float, rises: bool) -> None:
        if rises:
            self._check("enable_cycle", time_ns - self._rose)
            self._check("address_setup", time_ns - self._rs_changed)
            self._rose = time_ns
            return
        self._check("enable_width", time_ns - self._rose)
        self._check("data_setup", time_ns - self._data_changed)
        self._fell = time_ns
        self.writes += 1
        rs, nibble = self._bus & _RS, self._bus & _DATA
        if self.plugged and self.chip.write(round(time_ns), rs, nibble):
            self._show(time_ns)

    def _show(self, time_ns: float) -> None:
        rows = self.text
        if rows != self.history[-1].rows:
            self.history.append(Screen(time_ns / 1e9, rows))

    def _check(self, limit: str, time_ns: float) -> None:
        if time_ns < getattr(self.limits, limit):
            self.violations[limit] = self.violations.get(limit, 0) + 1
