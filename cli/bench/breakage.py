"""The faults that the user switches on and off: causes and cures of `verify`'s catalogue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.catalogue import causes
from heatwright.sim.faults.fault import Fault, nothing

if TYPE_CHECKING:
    from heatwright.cli.bench.world import LiveWorld

OUTLIVES = ("fan", "input", "relay")
"""Parts outside the board: a loss of power does not end their faults."""

Slots = frozenset[tuple[str, str]]
"""Places in the wiring: the kind of place, and its output or sensor."""


@dataclass(frozen=True)
class Cause:
    """One fault that can be caused; part, loop -- the part that fails, and its loop."""

    part: str
    loop: str
    fault: Fault

    @property
    def lasts(self) -> bool:
        """Whether the fault has a cure; if not, it ends itself, or `mend` restores the wiring."""
        return self.fault.cure is not nothing


class Breakage:
    """All possible faults, and the active ones; causes -- all, by their ids in the catalogue."""

    def __init__(self, world: LiveWorld, program: Elf) -> None:
        self._world = world
        self._active: dict[str, Slots] = {}
        self._renewing = False
        self.causes = {
            fault.id: Cause(part, loop, fault)
            for part, loop, fault in causes(world.site.controller, program)
        }

    @property
    def active(self) -> tuple[str, ...]:
        """Ids of the active faults, in the order in which they were caused."""
        return tuple(self._active)

    def bring(self, name: str) -> None:
        """Cause a fault. Raises LookupError: the catalogue does not have it."""
        cause = self._cause_of(name)
        if name in self._active:
            return
        for other in [each for each in self._active if self._excludes(cause, self._cause_of(each))]:
            self.mend(other)
        before = self._wired()
        with self._world.at(cause.loop):
            cause.fault.cause(self._world)
        changed = self._wired().items() ^ before.items()
        places = frozenset(place for place, _ in changed)
        if not cause.lasts and not places:
            return
        self._active = {
            other: taken for other, taken in self._active.items() if not taken & places
        }  # the new fault has replaced all others in its places
        self._active[name] = places

    def mend(self, name: str) -> None:
        """Remove the cause of a fault again."""
        cause = self._cause_of(name)
        places = self._active.pop(name, None)
        if places is None:
            return
        if cause.lasts:
            with self._world.at(cause.loop):
                cause.fault.cure(self._world)
            return
        wires = self._places()
        for kind, place in places:
            wires[kind].pop(place, None)

    def renew(self) -> None:
        """Cause again the faults of chips and pins, which a loss of power has ended."""
        if self._renewing:
            return
        self._renewing = True
        wiring = self._world.wiring
        heat, besides, feel = dict(wiring.heat), dict(wiring.besides), dict(wiring.feel)
        for name, slots in self._active.items():
            cause = self._cause_of(name)
            if slots or cause.part in OUTLIVES:
                continue
            with self._world.at(cause.loop):
                cause.fault.cause(self._world)
        wiring.heat, wiring.besides, wiring.feel = heat, besides, feel
        self._renewing = False

    @staticmethod
    def _excludes(cause: Cause, other: Cause) -> bool:
        """Return whether both are faults of one sensor, which can have only one at a time."""
        return cause.part == other.part == "sensor" and cause.loop == other.loop

    def _cause_of(self, name: str) -> Cause:
        if name not in self.causes:
            raise LookupError(f"The catalogue has no fault {name}.")
        return self.causes[name]

    def _wired(self) -> dict[tuple[str, str], Any]:
        """Return the content of each place in the wiring."""
        places = self._places().items()
        return {(kind, name): each for kind, found in places for name, each in found.items()}

    def _places(self) -> dict[str, dict[str, Any]]:
        wiring = self._world.wiring
        return {"heat": wiring.heat, "beside": wiring.besides, "feel": wiring.feel}
