"""How a chip on a bus sees its master: times that C checks, and calls from C to the chip."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from heatwright.sim.native.hw import Hw


@dataclass(frozen=True)
class Phase:
    """A checked time of the master: shortest and longest, µs or ns, and how often it was wrong."""

    least: float
    most: float
    violations: int


class Checked:
    """A chip's end of its bus, with the checked times of the master.

    names -- the names of these times; per_s -- number of their units in a second.
    """

    def __init__(self, hw: Hw, checks: Any, names: tuple[str, ...], per_s: float) -> None:
        self._hw, self._lib = hw, hw.lib
        self._checks, self._names, self._per_s = checks, names, per_s

    @property
    def phases(self) -> dict[str, Phase]:
        """The master's checked times so far; those that have not occurred are left out."""
        return {
            name: Phase(self._units(seen.least), self._units(seen.most), seen.violations)
            for name, seen in zip(self._names, self._checks[0 : len(self._names)], strict=True)
            if seen.least <= seen.most
        }

    @property
    def violations(self) -> int:
        """How often the master has violated a limit."""
        return sum(phase.violations for phase in self.phases.values())

    def _units(self, cycles: int) -> float:
        return cycles * self._per_s / self._hw.clock_hz


def callback(ffi: Any, name: str, act: Callable[..., None]) -> None:
    """Register a callback of callbacks.h; act -- gets the chip, then the other arguments of C."""

    def call(handle: Any, *arguments: Any) -> None:
        chip, errors = ffi.from_handle(handle)
        try:
            act(chip, *arguments)
        except BaseException as error:  # C cannot pass it on: Avr.run_to raises it
            errors.append(error)

    ffi.def_extern(name=name)(call)
