"""A text display on I²C: a PCF8574 expander (NXP data sheet, rev. 5), and behind it an HD44780.

The expander decodes its two lines edge by edge, and answers in the loop. Its outputs are the
display's bus: P0 RS, P1 R/W, P2 E, P3 the backlight, P4 to P7 D4 to D7. Nobody reads here: neither
the expander's inputs nor the display's memory.
"""

from __future__ import annotations

from codecs import charmap_decode
from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.lcd.hd44780 import A00, LINE_LENGTH, Hd44780
from heatwright.sim.native.pins import Level
from heatwright.spec import Board
from heatwright_i2c_lcd.model import I2cLcd as Spec

RS, RW, E, BACKLIGHT, DATA = 0x01, 0x02, 0x04, 0x08, 0xF0
POWER_ON = 0xFF
"""The expander's outputs after its supply has come."""
BYTE, ACKNOWLEDGED = 8, 9
"""Pulses of SCL: a byte, and one in which the receiver answers."""
RISE_US = 1.0
"""The longest time in which a line may rise: a released line counts as high so much later."""
KEPT = 500
"""Changes of the text that are kept."""


@dataclass(frozen=True)
class Limits:
    """Shortest times of the master, µs (UM10204, standard mode), and RISE_US where a line rises.

    period -- from one rise of SCL to the next: 100 kHz at most; low, high -- of SCL; setup -- from
    a change of SDA to the rise of SCL; start_setup -- from the rise of SCL to a start; start_hold
    -- from a start to the fall of SCL; stop_setup -- from the rise of SCL to a stop; free -- from a
    stop to a start.
    """

    period: float = 10.0
    low: float = 4.7
    high: float = 4.0 + RISE_US
    setup: float = 0.25 + RISE_US
    start_setup: float = 4.7 + RISE_US
    start_hold: float = 4.0
    stop_setup: float = 4.0 + RISE_US
    free: float = 4.7 + RISE_US


@dataclass(frozen=True)
class Screen:
    """The text that the display shows from a time on, s since the power came."""

    time_s: float
    rows: tuple[str, ...]


class Taken(Protocol):
    """What takes the bytes of a bus."""

    def __call__(self, byte: int, number: int, cycle: int, /) -> bool:
        """Take a byte; return whether it is acknowledged."""


class Glass(Hd44780):
    """The display's controller, with the glass: so many columns and rows."""

    def __init__(self, columns: int, rows: int) -> None:
        self._columns = columns
        starts = (0x00, 0x40, columns, 0x40 + columns)
        self._starts = starts[:rows]
        super().__init__()

    @property
    def rows(self) -> tuple[str, ...]:
        """What it shows: nothing while it is off, or before it is set to two lines of memory."""
        if not self.ready:
            return self.blank_rows
        return tuple(map(self._row_at, self._starts))

    @property
    def blank_rows(self) -> tuple[str, ...]:
        """The rows without text."""
        return (" " * self._columns,) * len(self._starts)

    def _row_at(self, start: int) -> str:
        line, first = start & 0x40, (start & 0x3F) + self._shift
        cells = bytes(
            self._ddram[line + (first + column) % LINE_LENGTH] for column in range(self._columns)
        )
        return charmap_decode(cells, "strict", A00)[0]


class Bus:
    """An I²C slave's end of its two lines: it decodes the bits, and acknowledges bytes.

    shortest -- of each of the master's times so far, µs; violations -- how often each was too
    short; silent -- it acknowledges nothing; holds_sda -- it holds SDA low now.
    """

    def __init__(self, avr: Avr, sda: str, scl: str, taken: Taken) -> None:
        """Listen on two pins, each with a resistor to the supply.

        taken -- called with each byte of a transfer, its number in it and the cycle of its end; it
        returns whether the slave acknowledges the byte.
        """
        self.silent = False
        self.shortest: dict[str, float] = {}
        self.violations: Counter[str] = Counter()
        self._avr, self._sda, self._taken = avr, sda, taken
        self._us = 1e6 / avr.clock_hz
        self._limits = vars(Limits())
        self._sda_low = self._scl_low = self.holds_sda = False
        self._in_transfer = False
        self._byte = self._pulses = self._number = 0
        self._last: dict[str, int] = {}
        """The cycle of each kind of event's last one."""
        for pin, heard in ((sda, self._on_sda), (scl, self._on_scl)):
            avr.pins.pull(pin, "high")
            avr.pins.listen(pin, heard)

    def forget(self) -> None:
        """Begin as after the power-up: wait for a start, and hold nothing."""
        self._hold(held=False)
        self._in_transfer = False

    def _hold(self, *, held: bool) -> None:
        if held != self.holds_sda:
            self.holds_sda = held
            self._avr.pins.hold(self._sda, held)

    def _judge(self, name: str, since: str, cycle: int) -> None:
        begun = self._last.get(since)
        if begun is None or not self._avr.program_counter:  # a reset has released the lines
            return
        lasted_us = (cycle - begun) * self._us
        self.shortest[name] = min(lasted_us, self.shortest.get(name, lasted_us))
        if lasted_us < self._limits[name]:
            self.violations[name] += 1

    def _on_sda(self, low: int, cycle: int) -> None:
        self._sda_low = bool(low)
        self._last["change"] = cycle
        if self._scl_low:
            return
        self._in_transfer = self._sda_low
        if low:
            self._judge("free", "stop", cycle)
            self._judge("start_setup", "rise", cycle)
            self._byte = self._pulses = self._number = 0
        else:
            self._judge("stop_setup", "rise", cycle)
        self._last["start" if low else "stop"] = cycle

    def _on_scl(self, low: int, cycle: int) -> None:
        self._scl_low = bool(low)
        if self._in_transfer:
            (self._fall if low else self._rise)(cycle)
        self._last["fall" if low else "rise"] = cycle

    def _rise(self, cycle: int) -> None:
        self._judge("low", "fall", cycle)
        self._judge("setup", "change", cycle)
        if self._pulses or self._number:
            self._judge("period", "rise", cycle)
        self._pulses += 1
        if self._pulses <= BYTE:
            self._byte = self._byte << 1 | (not self._sda_low)

    def _fall(self, cycle: int) -> None:
        if not self._pulses:
            self._judge("start_hold", "start", cycle)
            return
        self._judge("high", "rise", cycle)
        if self._pulses == BYTE:
            takes = self._taken(self._byte, self._number, cycle) and not self.silent
            self._hold(held=takes)
            self._in_transfer = takes  # without an acknowledgement it waits for the next start
        elif self._pulses == ACKNOWLEDGED:
            self._hold(held=False)
            self._number += 1
            self._byte = self._pulses = 0


class I2cLcd:
    """The display on its two pins.

    glass -- its controller; bus -- its end of the bus; history -- the latest changes of its text;
    broken -- how often the display's own lines were used wrongly, by what was wrong; transfers --
    how many were to its address.
    """

    def __init__(self, avr: Avr, board: Board, interface: Spec) -> None:
        self.glass = Glass(interface.columns, interface.rows)
        self.history: deque[Screen] = deque([Screen(0.0, self.glass.rows)], KEPT)
        self.broken: Counter[str] = Counter()
        self.transfers = 0
        self._avr = avr
        self._address = interface.address
        self._outputs = POWER_ON
        self._plugged = True
        self.pins = board.pins[interface.sda].port_name, board.pins[interface.scl].port_name
        self.bus = Bus(avr, *self.pins, self._take)

    @property
    def text(self) -> tuple[str, ...]:
        """The rows that it shows now."""
        return self.glass.rows if self._plugged else self.glass.blank_rows

    @property
    def is_lit(self) -> bool:
        """Whether its backlight is on."""
        return self._plugged and bool(self._outputs & BACKLIGHT)

    @property
    def complaints(self) -> Iterator[str]:
        """Yield the violations of the data sheets."""
        for name, count in self.bus.violations.items():
            yield f"I2C display: {name} of the bus was too short {count} times"
        for what, count in self.broken.items():
            yield f"I2C display: {what} {count} times"
        if self.glass.lost:
            yield f"I2C display: it was busy and lost {self.glass.lost} instructions or characters"

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Do nothing: its bus hears the pins as they change."""

    def unplug(self) -> None:
        """Disconnect it; the resistors at the board keep the lines high."""
        self._plugged = False
        self.bus.forget()
        self._show(self._avr.cycle)

    def plug(self) -> None:
        """Plug it in again: its supply comes back, and it has forgotten everything."""
        self._plugged = True
        self._outputs = POWER_ON
        self.glass.power_on(self._ns(self._avr.cycle))
        self._show(self._avr.cycle)

    def short(self, wire: Literal["sda", "scl"], level: Level | None) -> None:
        """Short a line to ground ("low") or to the supply ("high"); None ends it."""
        self._avr.pins.drive(self.pins[wire == "scl"], level)

    def _take(self, byte: int, number: int, cycle: int) -> bool:
        """Take the address, or the expander's outputs."""
        if number:
            self._set(byte, cycle)
            return True
        is_mine = self._plugged and byte == self._address << 1
        self.transfers += is_mine
        return is_mine

    def _set(self, outputs: int, cycle: int) -> None:
        before, self._outputs = self._outputs, outputs
        moved = before ^ outputs
        if not moved & E:
            return
        if outputs & E:
            self._note("RS or R/W changed as E rose", moved & (RS | RW))
        elif before & RW:
            self._note("it was read", before != POWER_ON)
        else:
            self._note("a line changed as E fell", moved & (RS | RW | DATA))
            if self.glass.write(self._ns(cycle), before & RS, (before & DATA) >> 4):
                self._show(cycle)

    def _note(self, what: str, happened: int) -> None:
        if happened:
            self.broken[what] += 1

    def _show(self, cycle: int) -> None:
        if self.text != self.history[-1].rows:
            self.history.append(Screen(cycle / self._avr.clock_hz, self.text))

    def _ns(self, cycle: int) -> int:
        return round(cycle * 1e9 / self._avr.clock_hz)


def attach(avr: Avr, board: Board, interface: Spec) -> I2cLcd:
    """Put a new display on its pins."""
    return I2cLcd(avr, board, interface)
