"""A small program in a processor, and what it has in its variables."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from rig.avr import compiled, powered

from heatwright.sim.binary.dwarf import Variables


class Small:
    """Compiled, powered on, and run for so long; a variable is had by its name, as Python's."""

    def __init__(
        self, source: str, *flags: str, mcu: str = "atmega328p", seconds: float = 0.0
    ) -> None:
        self.elf = compiled(source, *flags, mcu=mcu)
        self.avr = powered(self.elf, mcu)
        self.avr.run(seconds)

    @cached_property
    def _variables(self) -> Variables:
        return Variables(self.elf)

    def __getitem__(self, name: str) -> Any:
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        found = np.frombuffer(raw, variable.dtype.base)
        return found.tolist() if variable.dtype.shape else found[0].item()

    def __setitem__(self, name: str, value: float | Sequence[float]) -> None:
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype.base).tobytes())
