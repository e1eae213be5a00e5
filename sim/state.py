"""The state after each control step, read from the binary's RAM by the names in its source."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.binary.dwarf import Variables
from heatwright.sim.binary.elf import Elf
from heatwright.sim.native.hw import Log
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, facts_of

LOADED = "program.c:loaded"
"""The variable with the firmware's copy of the program."""


class StateLog:
    """The steps of one loop: images of the RAM with its state, decoded on request.

    The columns are the members of docs/control.md: those of the loop by their own names, the others
    with a prefix: ``guard.``, ``algorithm.``, ``autotune.``, ``program.``, ``fault.``, ``output.``,
    ``current.``, ``response.``, ``monitor_NAME.``. ``loaded`` is the copy of the running program.
    """

    def __init__(self, elf: Elf, variables: Variables, controller: Controller, name: str) -> None:
        self._counter = variables[f"loop_{name}.steps"]
        # A tick ends there. A master may be answered after it, before the processor sleeps.
        self._ends = elf.function("clock_wait")
        self._variables = variables
        self._columns = _columns(variables, controller, name)
        kept = [variables[path] for path in self._columns.values()]
        self._base = min(each.address for each in kept)
        self._size = max(each.address + each.size for each in kept) - self._base
        self._times: list[NDArray[np.float64]] = []
        self._images: list[NDArray[np.uint8]] = []
        self._snapshots: Log | None = None

    def record(self, avr: Avr, start_s: float) -> None:
        """Record a processor that has just been powered on, at start_s."""
        self._start_s, self._clock_hz = start_s, avr.clock_hz
        counter = (self._counter.address, self._counter.size)
        self._snapshots = avr.snapshots(counter, (self._base, self._size), self._ends)

    def collect(self) -> None:
        """Fetch the images that the processor has recorded since the last call."""
        if self._snapshots is not None:
            taken = self._snapshots.take()
            self._times.append(self._start_s + taken["cycle"] / self._clock_hz)
            self._images.append(taken["image"])

    def steps(self) -> StepLog:
        """Return one row for each step: ``time_s``, then the members."""
        self.collect()
        if not self._times:
            return np.empty(0, [("time_s", "f8"), *self._fields()])
        times, images = np.concatenate(self._times), np.concatenate(self._images)
        self._times, self._images = [times], [images]
        seen = self._variables.decode(images, self._base, self._columns.values())
        log = np.empty(len(times), [("time_s", "f8"), *self._fields()])
        log["time_s"] = times
        for column, path in self._columns.items():
            log[column] = seen[path]
        return log

    def take(self) -> StepLog:
        """Return the rows since the last call, and delete them."""
        log = self.steps()
        self._times, self._images = [], []
        return log

    def _fields(self) -> list[tuple[str, Any]]:
        return [(column, self._variables[path].dtype) for column, path in self._columns.items()]


def _columns(variables: Variables, controller: Controller, name: str) -> dict[str, str]:
    """Return the variable of each column; a loop has only the state that its parts need."""
    loop = controller.loops[name]
    has_programs = facts_of(controller, name).programmed
    sources = {
        "": f"loop_{name}",
        "guard.": f"guard_{name}",
        "algorithm.": f"algorithm_{name}",
        "autotune.": f"autotune_{name}",
        **({"program.": "program"} if has_programs else {}),
        "fault.": "fault",
        "output.": f"output_{loop.heater}",
        "current.": f"current_{loop.heater}",
        "response.": f"response_{name}",
        **{f"monitor_{each}.": f"monitor_{each}" for each in facts_of(controller, name).monitored},
    }
    found = {
        f"{prefix}{member}": f"{source}.{member}"
        for prefix, source in sources.items()
        if source in variables
        for member in variables[source].dtype.names or ()
    }
    return found | ({"loaded": LOADED} if has_programs else {})
