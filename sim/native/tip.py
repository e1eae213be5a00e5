"""The temperature of a sensor chip's tip: the machine sets it, the chip reads it to convert."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heatwright.sim.native.shim import load

if TYPE_CHECKING:
    from heatwright.sim.avr import Avr

BEGINS_C = 20.0


class Tip:
    """A tip and its past temperatures. pointer -- the tip in the shim, where C sets it."""

    def __init__(self, avr: Avr) -> None:
        native = load()
        self._lib, self._avr = native.lib, avr
        self.pointer = native.ffi.new("hw_tip *")
        self.pointer.felt[0] = BEGINS_C

    def tell(self, felt_c: float) -> None:
        """Set its temperature from now on, °C."""
        self._lib.hw_tip_tell(self.pointer, self._avr.cycle, felt_c)

    @property
    def felt_c(self) -> float:
        """Its present temperature, °C."""
        return float(self.pointer.felt[self.pointer.newest])

    @property
    def told_at(self) -> int:
        """The cycle at which it was last set."""
        return int(self.pointer.told_at)

    def felt_at_c(self, cycle: int) -> float:
        """Return its temperature at a cycle, °C, or the oldest one that is stored."""
        return float(self._lib.hw_tip_felt(self.pointer, max(0, cycle)))
