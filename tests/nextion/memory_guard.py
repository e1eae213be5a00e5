"""Memory, tick by tick: two boards side by side, one of them with something on its line.

All of RAM, the registers included, must be the same in both but for what is named; and nothing is
ever written between the variables and the stack.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.device import AvrDevice
from heatwright.sim.dwarf import Variable, Variables

FIRST = 0x20
"""Address of the first register; below are those of the core."""
CORE = range(0x5D, 0x60)
"""Stack pointer and status register."""
HASTY = re.compile(r"TCNT\d|UDR\d|UCSR\d[ABC]|TIFR\d|PIN[A-L]|EEAR|EEDR")
"""Registers that tell the very moment, those of the line, and where the EEPROM was read last."""
TICK = "clock.c:ticks_of_second"
"""Changes once a tick, in the main loop."""


class Difference(NamedTuple):
    """A byte that differs: after which tick, and which variable it belongs to."""

    tick: int
    address: int
    name: str


class Watched:
    """A board whose memory is noted each time it falls asleep after a tick.

    files -- source files whose variables may differ; ticks -- how many there were.
    """

    def __init__(self, device: AvrDevice, files: Sequence[str]) -> None:
        self.device = device
        self.ticks = 0
        variables, end = device.variables, device.elf.static_ram[1]
        counter = variables[TICK]
        self._images = device.avr.snapshots((counter.address, 1), (FIRST, end - FIRST))
        self._same = np.ones(end - FIRST, bool)
        for address in CORE:
            self._same[address - FIRST] = False
        for each in _free(variables, files):
            self._same[each.address - FIRST : each.address + each.size - FIRST] = False

    def take(self) -> tuple[NDArray[np.uint64], NDArray[np.uint8]]:
        """Cycles and images since the last call."""
        cycles, images = self._images.take()
        self.ticks += len(cycles)
        return cycles, images

    def differences(self, mine: NDArray[np.uint8], others: NDArray[np.uint8]) -> list[Difference]:
        """What differs that should not."""
        ticks, places = np.nonzero((mine != others) & self._same)
        first = self.ticks - len(mine)
        return [
            Difference(first + int(tick), FIRST + int(place), self._name(FIRST + int(place)))
            for tick, place in zip(ticks, places, strict=True)
        ]

    def _name(self, address: int) -> str:
        variables = self.device.variables
        for name in variables:  # type: ignore[attr-defined]
            found = variables[name]
            if found.address <= address < found.address + found.size:
                return str(name)
        return f"0x{address:04x}"


def _free(variables: Variables, files: Sequence[str]) -> list[Variable]:
    registers = [each for each in variables.of_file("") if HASTY.fullmatch(each.name)]
    return registers + [each for file in files for each in variables.of_file(file)]


class Pair:
    """A quiet board and a disturbed one, run together; latest -- cycles a tick was late."""

    def __init__(self, quiet: AvrDevice, disturbed: AvrDevice, files: Sequence[str]) -> None:
        self.quiet, self.disturbed = Watched(quiet, files), Watched(disturbed, files)
        self.latest = 0

    def run_to(self, time_s: float) -> None:
        """Run both; raises AssertionError at the first byte that differs."""
        for each in (self.quiet, self.disturbed):
            each.device.advance(time_s)
            each.device.feed()
        cycles, images = self.quiet.take()
        others_cycles, others = self.disturbed.take()
        assert len(cycles) == len(others_cycles), f"ticks are missing before {time_s} s"
        found = self.disturbed.differences(others, images)
        assert not found, found[:5]
        if len(cycles):
            late = others_cycles.astype(np.int64) - cycles.astype(np.int64)
            self.latest = max(self.latest, int(late.max()))
