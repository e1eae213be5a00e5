"""Pins of a simulated processor, by port and bit: ``"PD3"``."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.hw import Hw, Log

PIN_EVENT = np.dtype(
    {"names": ["cycle", "pin", "state"], "formats": ["<u8", "u1", "u1"], "itemsize": 16}
)
"""A change of a watched pin. state & 1 is the level, state >> 1 the Source."""

Level = Literal["low", "high"]
_LEVELS: dict[str | None, int] = {None: 0, "low": 1, "high": 2}


class Source(IntEnum):
    """What determines a pin's level."""

    MCU = 0
    OTHERS = 1
    RESISTOR = 2
    PULL_UP = 3
    FLOATING = 4


def pin_number(name: str) -> int:
    """Return the shim's number of a pin, 8 x port + bit; ValueError if it is no pin's name."""
    if len(name) == 3 and name[0] == "P" and "A" <= name[1] <= "L" and "0" <= name[2] <= "7":
        return 8 * (ord(name[1]) - ord("A")) + int(name[2])
    raise ValueError(f"{name!r} is not a pin: PB3 is port B, bit 3.")


def pin_name(number: int) -> str:
    """Return the name of the shim's pin number."""
    return f"P{chr(ord('A') + number // 8)}{number % 8}"


class Pins:
    """The pins: levels from outside, present levels, and for how long each was high.

    A pin's level comes from the first of these that exists: a strong driver outside (``drive``), a
    simulated chip that drives the pin, the processor's output, the board's resistor (``pull``),
    the processor's own pull-up. Without any of these it keeps its last level, and floats.
    """

    def __init__(self, hw: Hw) -> None:
        self._lib, self._hw, self._owner = hw.lib, hw.pointer, hw
        self.log = Log(hw, hw.lib.HW_PIN_LOG, PIN_EVENT)

    def watch(self, pin: str, *, logged: bool = True) -> int:
        """Watch a pin from now on; log its changes if `logged`. Return its number."""
        number = pin_number(pin)
        self._check(pin, self._lib.hw_pin_watch(self._hw, number, logged))
        return number

    def drive(self, pin: str, level: Level | None) -> None:
        """Force a level onto a pin as a strong driver or a short would; None: remove it."""
        self._check(pin, self._lib.hw_pin_drive(self._hw, pin_number(pin), _LEVELS[level]))

    def pull(self, pin: str, level: Level | None) -> None:
        """Put a resistor to supply or ground on a pin; None: remove it."""
        self._check(pin, self._lib.hw_pin_pull(self._hw, pin_number(pin), _LEVELS[level]))

    def listen(self, pin: str, heard: Callable[[int, int], None]) -> None:
        """Call ``heard(low, cycle)`` at each edge that no chip makes, for a bus in Python."""
        handle = self._owner.ffi.new_handle((heard, self._owner.errors))
        self._owner.kept.append(handle)
        self._check(pin, self._lib.hw_pin_listen(self._hw, pin_number(pin), handle))

    def hold(self, pin: str, held: bool) -> None:
        """Hold a pin low as one more chip with an open drain, or let one of them release it."""
        self._lib.hw_pin_hold(self._hw, self.watch(pin, logged=False), held)

    def level(self, pin: str) -> bool:
        """Return whether a watched pin is high."""
        return bool(self._lib.hw_pin_state(self._hw, pin_number(pin)) & 1)

    def source(self, pin: str) -> Source:
        """Return the source of a watched pin's level."""
        return Source(self._lib.hw_pin_state(self._hw, pin_number(pin)) >> 1)

    def high_cycles(self, number: int) -> int:
        """Return the cycles for which a pin, by its number, was high since it is watched."""
        cycles: int = self._lib.hw_pin_high_cycles(self._hw, number)
        return cycles

    def rises(self, number: int) -> int:
        """Return how often a watched pin, by its number, has gone from low to high."""
        rises: int = self._lib.hw_pin_rises(self._hw, number)
        return rises

    def contention_cycles(self, pin: str) -> int:
        """Return the cycles in which the processor drove a pin against a forced level."""
        return int(self._lib.hw_pin_contention_cycles(self._hw, pin_number(pin)))

    def take(self) -> NDArray[Any]:
        """Return the changes of the logged pins since the last call (PIN_EVENT records)."""
        return self.log.take()

    @staticmethod
    def _check(pin: str, failed: int) -> None:
        if failed:
            raise ValueError(f"This processor has no pin {pin}.")
