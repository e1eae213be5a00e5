"""Collects all that the page shows of the board, as plain values for JSON."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.cli.bench.parts.seat import Seat
from heatwright.cli.bench.store import Point, Store, as_told
from heatwright.cli.bench.world import LiveWorld
from heatwright.sim.binary.dwarf import Variable
from heatwright.sim.judges.permits import missing
from heatwright.spec import RULES

JOURNAL = "journal"
MOST_ELEMENTS = 16
"""Maximum number of elements of an array that are listed one by one."""


class View:
    """Reads the values of a world, and of the seats at its interfaces."""

    def __init__(self, world: LiveWorld, seats: Sequence[Seat]) -> None:
        self._world, self._seats = world, seats
        self._controller = world.site.controller
        self._journal: list[Any] = []
        self._latched = 0
        self._named = dict(_scalars(world))
        places = [(each.address, each.address + each.size) for each in self._named.values()]
        self._from = min(first for first, _ in places)
        self._size = max(end for _, end in places) - self._from

    def journal(self, time_s: float, text: str) -> None:
        """Add a line to the journal: an action of the user, or a fault of the firmware."""
        self._journal.append([round(time_s, 3), text])

    # -- data that never change ----------------------------------------------------------------

    def about(self, name: str) -> dict[str, Any]:
        """Return the data that never change: names, limits, possible faults."""
        controller, world = self._controller, self._world
        network = world.site.network
        return {
            "spec": name,
            "name": controller.identity.name,
            "title": controller.identity.title or controller.identity.name,
            "board": controller.board.name,
            "loops": {
                loop: {
                    "heater": each.heater,
                    "sensor": each.sensor,
                    "node": network.sense[each.sensor].node,
                    "minimum_c": each.protection.minimum_c,
                    "maximum_c": each.protection.maximum_c,
                }
                for loop, each in controller.loops.items()
            },
            "interfaces": [
                {"number": seat.number, "kind": seat.kind, **seat.about()} for seat in self._seats
            ],
            "faults": [
                {"id": fault, "part": each.part, "loop": each.loop, "lasts": each.lasts}
                for fault, each in world.breakage.causes.items()
            ],
            "heaters_w": dict(world.heaters_w),
            "feeds": network.filament is not None,
            "variables": list(self._named),
        }

    # -- present values ------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Return all values that the page shows now."""
        world, device = self._world, self._world.device
        self._note_fault()
        return {
            "time_s": round(world.now_s, 2),
            "loops": {loop: self._loop(loop) for loop in self._controller.loops},
            "fault": self._fault(),
            "outputs": {name: each.on for name, each in device.outputs.items()},
            "relay": None if device.relay is None else device.relay.closed,
            "nodes_c": {name: round(each_c, 2) for name, each_c in world.nodes_c.items()},
            "faults": list(world.breakage.active),
            "ambient_c": world.ambient_c,
            "supply_percent": round(100 * world.wiring.volts, 1),
            "taken_w": {name: round(watts, 2) for name, watts in world.taken_w.items()},
            "feed_mm_per_s": world.coupling.extruded_mm_per_s,
            "interfaces": [seat.state(world) for seat in self._seats],
        }

    def _loop(self, name: str) -> dict[str, Any]:
        world = self._world
        with world.at(name):
            return {
                "temperature_c": _plain(world.loop("temperature_c"), 2),
                "setpoint_c": _plain(world.loop("setpoint_c"), 2),
                "duty_percent": _plain(world.loop("duty_percent"), 1),
                "heater_on": world.device.outputs[world.site.loop.heater].on,
                "missing": [
                    each._asdict() for each in missing(world.device, self._controller, name)
                ],
            }

    def _fault(self) -> dict[str, Any] | None:
        code = self._world.fault
        if not code:
            return None
        rule = RULES.get(code)
        if rule is None:
            return {"code": code, "id": "", "meaning": "No rule has this code.", "remedy": ""}
        return {"code": code, "id": rule.id, "meaning": rule.meaning, "remedy": rule.remedy}

    def _note_fault(self) -> None:
        code = self._world.fault
        if code == self._latched:
            return
        self._latched = code
        found = self._fault()
        said = f"fault {found['id']}: {found['meaning']}" if found else "the fault is acknowledged"
        self.journal(self._world.now_s, said)

    # -- data since the last call --------------------------------------------------------------

    def points(self) -> dict[str, list[Point]]:
        """Return each loop's new points: time, s; measured, true, set temperature, °C; duty, %."""
        self._world.forget()
        return {
            loop: list(zip(*map(_column, course), strict=True))
            for loop, course in self._world.take_courses().items()
        }

    def lines(self) -> dict[str, list[Any]]:
        """Return the new lines of all consoles and of the journal."""
        found = {
            str(seat.number): [as_told(line) for line in lines]
            for seat in self._seats
            if (lines := seat.lines(self._world))
        }
        if self._journal:
            found[JOURNAL], self._journal = self._journal, []
        return found

    def variables(self) -> dict[str, Any]:
        """Return every variable of the program, by its name."""
        raw = self._world.device.avr.read_ram(self._from, self._size)
        return {
            name: _plain(np.frombuffer(raw, each.dtype, 1, each.address - self._from)[0].item(), 6)
            for name, each in self._named.items()
        }

    def draw(self, store: Store) -> None:
        """Draw the touch displays on which something has changed."""
        for seat in self._seats:
            if (picture := seat.picture(self._world)) is not None:
                store.draw(seat.number, picture)


def _plain(value: Any, digits: int) -> Any:
    """Return a number for JSON; None if it is not finite."""
    number = float(value)
    if not math.isfinite(number):
        return None
    return round(number, digits) if isinstance(value, float | np.floating) else int(value)


def _column(values: NDArray[np.float64]) -> Sequence[float | None]:
    """Return numbers for JSON; None for each that is not finite."""
    rounded: list[float] = np.round(values, 3).tolist()
    if np.isfinite(values).all():
        return rounded
    return [each if math.isfinite(each) else None for each in rounded]


def _scalars(world: LiveWorld) -> Iterator[tuple[str, Variable]]:
    """Yield the program's own variables; members of structures and short arrays one by one."""
    variables = world.device.variables
    for file in variables.files:
        for each in variables.of_file(file):
            yield from _apart(f"{file.removesuffix('.c')}:{each.name}", each)


def _apart(name: str, variable: Variable) -> Iterator[tuple[str, Variable]]:
    dtype: np.dtype[Any] = variable.dtype
    if dtype.fields is not None:
        for member in dtype.names or ():
            yield from _apart(f"{name}.{member}", variable.step(member))
    elif dtype.subdtype is not None:
        count = dtype.subdtype[1][0]
        for index in range(count if count <= MOST_ELEMENTS else 0):
            yield from _apart(f"{name}[{index}]", variable.element(index))
    elif dtype.kind in "iufb":
        yield name, variable
