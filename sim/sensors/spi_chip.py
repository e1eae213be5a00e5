"""Shared by the thermocouple converters on three or four wires."""

import random
from dataclasses import dataclass
from typing import Literal, Protocol

from heatwright.sim.avr import Avr
from heatwright.sim.native.pins import Level
from heatwright.sim.native.spi import Port, Timing, Wires
from heatwright.sim.native.tip import Tip
from heatwright.spec import Board

REMEMBERED_S = 2.0
"""How old a temperature conversions may use, s: longer than any slow conversion."""

Wire = Literal["ground", "supply"]


@dataclass
class Faults:
    """Ways to fail, set at any time.

    open -- the thermocouple is broken; frozen -- conversions do not change the reading; slow --
    factor on the data sheet's longest conversion time; dumb -- it answers with zeros, like a chip
    without clock or a burnt one; corrupt_next, corrupt_rate -- number of the next answers, or share
    of all answers (0..1, seeded), with one of the `corruptible` bits inverted.
    """

    open: bool = False
    frozen: bool = False
    slow: float = 1.0
    dumb: bool = False
    corrupt_next: int = 0
    corrupt_rate: float = 0.0


class SpiChip:
    """A converter on its wires; its subclass defines the answer.

    tip -- the thermocouple's tip; faults -- see Faults; port -- the chip's end of the wires;
    reads -- number of answers begun.
    """

    longest_s: float
    """Longest conversion, s."""
    bits: int
    driven: int
    """Number of bits it drives; after them its data line floats."""
    corruptible: tuple[int, ...]
    """Bits of an answer, 0 the last one sent, that a disturbance may invert."""

    def __init__(self, avr: Avr, wires: Wires, *, timing: Timing, seed: int = 1) -> None:
        self.tip = Tip(avr)
        self.faults = Faults()
        self.reads = 0
        self._avr = avr
        self._wires = wires
        self._random = random.Random(seed)  # noqa: S311 - noise, not a secret
        self._power_on(avr.cycle)
        self.port: Port = avr.spi(wires, self, timing)

    @property
    def violations(self) -> dict[str, int]:
        """Count violations of the data sheet's timing, by phase."""
        return {phase: seen.violations for phase, seen in self.port.phases.items()}

    def sense(self, temperature_c: float) -> None:
        """Set the temperature of the thermocouple's tip from now on, °C."""
        self.tip.tell(temperature_c)

    # -- faults --------------------------------------------------------------------------------

    def unplug(self) -> None:
        """Disconnect the chip from its wires and its supply."""
        self.port.connect(False)

    def plug(self) -> None:
        """Plug the chip in again: it starts again."""
        self.brown_out()
        self.port.connect(True)

    def short(self, level: Level | None) -> None:
        """Short the data line to ground ("low") or to supply ("high"); None removes the short."""
        self._avr.pins.drive(self._wires.data, level)

    def brown_out(self) -> None:
        """Interrupt the chip's supply: it loses its results."""
        self._power_on(self._avr.cycle)

    # -- the wires -----------------------------------------------------------------------------

    def selected(self, cycle: int) -> None:
        """Load the answer when the processor selects the chip."""
        self.reads += 1
        self._go_on(cycle)
        word = 0 if self.faults.dumb else self._maybe_corrupt(self._word())
        self.port.load(word, self.bits, self.bits if self.faults.dumb else self.driven)

    def released(self, cycle: int) -> None:
        """Process the end of a selection."""
        raise NotImplementedError

    def _maybe_corrupt(self, word: int) -> int:
        faults = self.faults
        if faults.corrupt_next:
            faults.corrupt_next -= 1
        elif not (faults.corrupt_rate and self._random.random() < faults.corrupt_rate):
            return word
        return word ^ 1 << self._random.choice(self.corruptible)

    # -- measuring -----------------------------------------------------------------------------

    def _power_on(self, cycle: int) -> None:
        """Start again at a cycle."""
        raise NotImplementedError

    def _go_on(self, cycle: int) -> None:
        """Compute the conversions that have ended up to a cycle."""
        raise NotImplementedError

    def _word(self) -> int:
        """Return the answer to send."""
        raise NotImplementedError

    def _cycles(self, seconds: float) -> int:
        return round(seconds * self._avr.clock_hz)

    @property
    def _conversion_cycles(self) -> int:
        return self._cycles(self.longest_s * self.faults.slow)

    def _felt_c(self, cycle: int) -> float:
        """Return the tip's temperature at a cycle, °C."""
        oldest = self.tip.told_at - self._cycles(REMEMBERED_S) - 1
        return self.tip.felt_at_c(max(cycle, oldest))


class OnSpi(Protocol):
    """The spec of a sensor on three or four wires."""

    @property
    def chip_select(self) -> str:
        """Pin at its CS."""

    @property
    def clock(self) -> str:
        """Pin at its SCK."""

    @property
    def data_out(self) -> str:
        """Pin at its data output."""

    @property
    def data_in(self) -> str | None:
        """Pin at its data input; None if it has none."""


def wires_of(board: Board, sensor: OnSpi) -> Wires:
    """Return the wires of a sensor in the spec."""
    names = [sensor.chip_select, sensor.clock, sensor.data_out]
    if sensor.data_in is not None:
        names.append(sensor.data_in)
    return Wires(*(board.pins[name].port_name for name in names))
