"""Feeds the reference model with what went into each control step of a log."""

from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from heatwright.sim.reference import Reference
from heatwright.sim.reference.copies import from_cell
from heatwright.sim.reference.inputs import Gains, Limits, Orders
from heatwright.sim.reference.loop import EMERGENCY_STOP, MASTER_LOST, WATCHED_FAULTS
from heatwright.sim.reference.monitor import MONITOR_LIMIT
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.sim.reference.program_state import START
from heatwright.sim.reference.resumed import resumed
from heatwright.spec import Controller
from heatwright.spec.adjusted import KINDS

ACKNOWLEDGEMENTS = "fault.acknowledgements"
STARTS = "autotune.starts"
LOADED = "loaded"
"""Columns of inputs."""


@dataclass(frozen=True)
class Restored:
    """A fault that was there at the first step after a reset without having tripped in it."""

    row: int
    time_s: float
    fault_code: int


@dataclass(frozen=True)
class Latched:
    """A fault that was latched since the step before: by this loop, or else by another."""

    row: int
    time_s: float
    fault_code: int
    own: bool


class Player:
    """Feeds the reference, row by row."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Begin before the first step."""
        self._has_others = len(controller.loops) > 1
        self.latched: list[Latched] = []
        self._controller = controller
        self._loop = loop
        self._reference = Reference(controller, loop)
        self.members = list(self._reference.members)
        self.segments = 0
        """Runs of steps from one reset to the next, so far."""
        self.restored: list[Restored] = []
        self._last: np.void | None = None

    def play(self, number: int, row: np.void) -> tuple[object, ...]:
        """Return what the reference makes of a row, member by member."""
        if self._last is None or self._is_reset(row, self._last):
            return self._first_of_segment(number, row)
        self._acknowledge(_counted(ACKNOWLEDGEMENTS, row, self._last), self._passed_c(row))
        starts = _counted(STARTS, row, self._last)
        self._last = row
        lost = bool(row["fault.code"] == MASTER_LOST)
        if self._reference.fault_code or not row["fault.code"]:
            return self._fed(row, starts, lost=lost)
        return self._tripped(number, row, starts, lost=lost)

    def _tripped(self, number: int, row: np.void, starts: int, *, lost: bool) -> tuple[object, ...]:
        """Do a step after which a fault is latched: one of this loop, or else of another.

        Another loop's comes before the step or, if that loop is later in the same tick, after it.
        """
        before = deepcopy(self._reference) if self._has_others else None
        values = self._fed(row, starts, lost=lost)
        code, temperature_c = int(row["fault.code"]), Single(row["fault.temperature_c"])
        own = self._reference.fault_code == code and (
            before is None or self._is_equal(values, row)  # several can trip the same rule at once
        )
        self.latched.append(Latched(number, float(row["time_s"]), code, own))
        if own or before is None:
            return values
        later = self._latched_after(values, row)
        if later is not None:
            return later
        self._reference = before
        before.restore(code, temperature_c)
        return self._fed(row, starts, lost=False)

    def _latched_after(self, values: tuple[object, ...], row: np.void) -> tuple[object, ...] | None:
        """Latch another loop's fault after a step; None where the row shows that it was not so."""
        said = {name: row[name] for name in ("fault.code", "fault.temperature_c")}
        later = tuple(
            said.get(name, value) for (name, _), value in zip(self.members, values, strict=True)
        )
        if not self._has_others or not self._is_equal(later, row):
            return None
        self._reference.restore(int(row["fault.code"]), Single(row["fault.temperature_c"]))
        return later

    def _first_of_segment(self, number: int, row: np.void) -> tuple[object, ...]:
        self.segments += 1
        self._last = row
        values = self._begun_with(0, row)
        code = int(row["fault.code"])
        tripped = self._reference.fault_code and (
            code not in (*WATCHED_FAULTS, MONITOR_LIMIT) or self._is_equal(values, row)
        )
        time_s = float(row["time_s"])
        if code and tripped:
            self.latched.append(Latched(number, time_s, code, own=True))
        if not code or tripped:
            return values
        restored = self._begun_with(code, row)
        if not self._is_equal(restored, row):
            later = self._latched_after(self._begun_with(0, row), row)
            if later is not None:
                self.latched.append(Latched(number, time_s, code, own=False))
                return later
            restored = self._begun_with(code, row)
        self.restored.append(Restored(number, time_s, code))
        return restored

    def _begun_with(self, code: int, row: np.void) -> tuple[object, ...]:
        """Do the first step of a segment after a fault; 0 is an acknowledged one, or none.

        What was acknowledged before it has gone, whichever it was.
        """
        self._reference = Reference(self._controller, self._loop)
        acknowledged, told_c = _counted(ACKNOWLEDGEMENTS, row), Single(row["fault.temperature_c"])
        self._acknowledge(acknowledged, told_c)
        if code or not acknowledged:
            self._reference.restore(code, told_c)
        if self._reference.program:
            self._reference.program.restore(resumed(row))
            self._load(row)
        return self._fed(row, _counted(STARTS, row), lost=False)

    def _passed_c(self, row: np.void) -> Single:
        """Return the temperature of a fault that came and went since the step before.

        A stop has none. Another loop's is what the row says, if no fault has come since.
        """
        seen = self._has_others and not row["fault.code"]
        return Single(row["fault.temperature_c"]) if seen else ZERO

    def _acknowledge(self, times: int, passed_c: Single = ZERO) -> None:
        for _ in range(times):
            if not self._reference.fault_code:  # it came since the last step
                self._reference.restore(EMERGENCY_STOP, passed_c)
            self._reference.acknowledge()

    def _fed(self, row: np.void, starts: int, *, lost: bool) -> tuple[object, ...]:
        if row["fault.code"] == EMERGENCY_STOP:
            self._reference.stop()
        if self._reference.program and row["program.order"] == START:
            self._load(row)
        if tuner := self._reference.steering.tuner:
            for _ in range(starts):
                tuner.start(int(row["autotune.cycles"]))
        record = self._reference.step(
            int(row["reading_status"]),
            int(row["reading_raw"]),
            Single(row["setpoint_c"]),
            orders=_orders(row, lost=lost),
        )
        return tuple(record.values())

    def _is_equal(self, values: tuple[object, ...], row: np.void) -> bool:
        return all(
            row[name] == value for (name, _), value in zip(self.members, values, strict=True)
        )

    def _load(self, row: np.void) -> None:
        if program := self._reference.program:
            number = int(row["program.argument"] or row["program.number"])
            program.load(number, from_cell(row[LOADED]))

    @staticmethod
    def _is_reset(row: np.void, last: np.void) -> bool:
        return bool(row["steps"] == 1 and last["steps"] != 0)


class _Told(NamedTuple):
    """What a log has of the inputs that not every loop has.

    numbers -- by field of the algorithm; monitors -- by name: members for status and raw number.
    """

    names: frozenset[str]
    numbers: dict[str, str]
    monitors: dict[str, tuple[str, str]]


@lru_cache(maxsize=64)
def _told(names: tuple[str, ...]) -> _Told:
    """Find them by the names of a log's members."""
    keyed = {kind.field: f"algorithm.{kind.field}" for kind in KINDS}
    watched = [name.partition(".")[0] for name in names if name.endswith(".warns")]
    return _Told(
        frozenset(names),
        {field: name for field, name in keyed.items() if name in names},
        {
            each.removeprefix("monitor_"): (f"{each}.reading_status", f"{each}.reading_raw")
            for each in watched
        },
    )


def _orders(row: np.void, *, lost: bool) -> Orders:
    names, numbers, monitors = _told(_names(row))
    code = int(row["fault.code"])
    given: dict[str, Any] = {
        "master_lost": lost,
        "watch_fault": code if code in WATCHED_FAULTS else 0,
        "numbers": {field: Single(row[name]) for field, name in numbers.items()},
        "monitors": {
            name: (int(row[status]), int(row[raw])) for name, (status, raw) in monitors.items()
        },
    }
    if "enabled" in names:
        given["enabled"] = int(row["enabled"])
    if "current.raw" in names:
        given["current_raw"] = int(row["current.raw"])
    if "guard.maximum_c" in names:
        given["maximum_c"] = Single(row["guard.maximum_c"])
    if "program.order" in names:
        given["program"] = (int(row["program.order"]), int(row["program.argument"]))
    if "mode" in names:
        given["mode"] = int(row["mode"])
        given["manual_percent"] = Single(row["manual_percent"])
        given["gains"] = Gains(*(Single(row[f"algorithm.{gain}"]) for gain in Gains._fields))
    if "output_maximum_percent" in names:
        given["limits"] = Limits(*(Single(row[f"{limit}_percent"]) for limit in Limits._fields))
    return Orders(**given)


def _counted(member: str, row: np.void, last: np.void | None = None) -> int:
    """Return by how much a count of 8 bits went on, or since the reset; 0 if the log has none."""
    if member not in _told(_names(row)).names:
        return 0
    return (int(row[member]) - (0 if last is None else int(last[member]))) & 0xFF


def _names(row: np.void) -> tuple[str, ...]:
    return row.dtype.names or ()
