"""The binary's control steps, done again by the reference model and compared bit for bit.

What went into each step is fed to the reference: the reading, the setpoint, the operator's
acknowledgement; of a commanded loop also its switch and mode, the duty by hand and the gains, an
emergency stop and the start of a tuning; of a programmed one the orders and the copy of the
program; the critical temperature; the heater's current. Every other member must come out equal, to
the last bit.

Some inputs are not in the log as such. Acknowledgements and starts show in their counts, a stop, a
lost master and a bad relay in the fault's code. A fault that outlived a reset, or caused it, shows
in the first step after the reset; those are listed in `ReplayResult.restored`, for whoever knows
whether there was one. So does a program that outlived it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.reference import Reference
from heatwright.sim.reference.copies import from_cell
from heatwright.sim.reference.inputs import Gains, Orders
from heatwright.sim.reference.loop import EMERGENCY_STOP, MASTER_LOST, RELAY_FAULTS
from heatwright.sim.reference.members import Member
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.program_state import START
from heatwright.sim.reference.resumed import resumed
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller

MOST_SHOWN = 10

ACKNOWLEDGEMENTS = "fault.acknowledgements"
STARTS = "autotune.starts"
LOADED = "loaded"
NO_MEMBERS = ("time_s", LOADED)


class ReplayError(ValueError):
    """The log cannot be replayed."""


@dataclass(frozen=True)
class Mismatch:
    """One member of the state that differs after one step."""

    row: int
    time_s: float
    variable: str
    expected: str
    """What the reference computed, as a number and its bits."""
    actual: str

    def __str__(self) -> str:
        """Say it in one line."""
        return (
            f"step {self.row} at {self.time_s:.3f} s: {self.variable} is {self.actual}, "
            f"not {self.expected}"
        )


@dataclass(frozen=True)
class Restored:
    """A fault that was there at the first step after a reset without having tripped in it."""

    row: int
    fault_code: int


@dataclass(frozen=True)
class ReplayResult:
    """How the binary and the reference compare."""

    ticks: int
    """Control steps compared."""
    mismatches: int
    """Members that differ, over all steps."""
    first: tuple[Mismatch, ...]
    """The first few of them."""
    segments: int
    """Runs of steps from one reset to the next."""
    restored: tuple[Restored, ...]
    unchecked: tuple[str, ...]
    """Members of the log that the reference does not have."""


def replay(controller: Controller, log: StepLog, loop: str | None = None) -> ReplayResult:
    """Compare a log of control steps with the reference model.

    The step counter must go on by one each time: a missing or repeated step is a mismatch. A
    counter of 1 out of turn is a reset.

    Args:
        controller: the specification.
        log: one row per control step.
        loop: name of the loop; the first if None.

    Raises:
        ReplayError: the log is empty or lacks a member.

    """
    name = loop or next(iter(controller.loops))
    if not len(log):
        message = "There are no control steps to compare"
        raise ReplayError(message)
    player = _Player(controller, name)
    _check_members(log, player.members)
    expected = np.array(
        [player.play(number, row) for number, row in enumerate(log)], player.members
    )
    found = [
        (int(row), member)
        for member, _ in player.members
        for row in np.flatnonzero(_bits(expected[member]) != _bits(log[member]))
    ]
    found.sort(key=lambda item: item[0])
    return ReplayResult(
        ticks=len(log),
        mismatches=len(found),
        first=tuple(_mismatch(log, expected, *item) for item in found[:MOST_SHOWN]),
        segments=player.segments,
        restored=tuple(player.restored),
        unchecked=tuple(sorted({*(log.dtype.names or ())} - {*NO_MEMBERS, *dict(player.members)})),
    )


def _check_members(log: StepLog, members: list[Member]) -> None:
    found = log.dtype.names or ()
    wanted = [name for name, _ in members]
    if any(name.startswith("program.") for name in wanted):
        wanted.append(LOADED)
    lacking = [name for name in wanted if name not in found]
    if lacking:
        message = f"The log lacks {', '.join(lacking)}"
        raise ReplayError(message)
    for name, width in members:
        if log.dtype[name] != np.dtype(width):
            message = f"{name} is {log.dtype[name]} in the log, not {np.dtype(width)}"
            raise ReplayError(message)


class _Player:
    """Feeds the reference."""

    def __init__(self, controller: Controller, loop: str) -> None:
        self._controller = controller
        self._loop = loop
        self._reference = Reference(controller, loop)
        self.members = list(self._reference.members)
        self.segments = 0
        self.restored: list[Restored] = []
        self._last: np.void | None = None

    def play(self, number: int, row: np.void) -> tuple[object, ...]:
        if self._last is None or self._is_reset(row, self._last):
            return self._first_of_segment(number, row)
        for _ in range(_counted(ACKNOWLEDGEMENTS, self._last, row)):
            self._reference.stop()  # unless there is a fault already, it came since the last step
            self._reference.acknowledge()
        starts = _counted(STARTS, self._last, row)
        self._last = row
        return self._fed(row, starts, lost=bool(row["fault.code"] == MASTER_LOST))

    def _first_of_segment(self, number: int, row: np.void) -> tuple[object, ...]:
        self.segments += 1
        self._last = row
        values = self._begun_with(0, row)
        code = int(row["fault.code"])
        tripped = self._reference.fault_code and (
            code not in RELAY_FAULTS or self._is_equal(values, row)
        )
        if not code or tripped:
            return values
        self.restored.append(Restored(number, code))
        return self._begun_with(code, row)

    def _begun_with(self, code: int, row: np.void) -> tuple[object, ...]:
        """Do the first step of a segment after a fault; 0 is an acknowledged one, or none."""
        self._reference = Reference(self._controller, self._loop)
        self._reference.restore(code, Single(row["fault.temperature_c"]))
        if self._reference.program:
            self._reference.program.restore(resumed(row))
            self._load(row)
        return self._fed(row, int(row[STARTS]) if STARTS in _names(row) else 0, lost=False)

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


def _orders(row: np.void, *, lost: bool) -> Orders:
    names = _names(row)
    code = int(row["fault.code"])
    orders = Orders(master_lost=lost, relay_fault=code if code in RELAY_FAULTS else 0)
    if "enabled" in names:
        orders = orders._replace(enabled=int(row["enabled"]))
    if "current.raw" in names:
        orders = orders._replace(current_raw=int(row["current.raw"]))
    if "guard.maximum_c" in names:
        orders = orders._replace(maximum_c=Single(row["guard.maximum_c"]))
    if "program.order" in names:
        orders = orders._replace(program=(int(row["program.order"]), int(row["program.argument"])))
    if "mode" in names:
        orders = orders._replace(
            mode=int(row["mode"]),
            manual_percent=Single(row["manual_percent"]),
            gains=Gains(*(Single(row[f"algorithm.{gain}"]) for gain in Gains._fields)),
        )
    return orders


def _counted(member: str, last: np.void, row: np.void) -> int:
    """Return by how much a count of 8 bits went on; 0 if the log does not have it."""
    return (int(row[member]) - int(last[member])) & 0xFF if member in _names(row) else 0


def _names(row: np.void) -> tuple[str, ...]:
    return row.dtype.names or ()


def _bits(values: NDArray[np.generic]) -> NDArray[np.generic]:
    return np.ascontiguousarray(values).view(f"u{values.dtype.itemsize}")


def _mismatch(log: StepLog, expected: StepLog, row: int, member: str) -> Mismatch:
    return Mismatch(
        row=row,
        time_s=float(log["time_s"][row]),
        variable=member,
        expected=_shown(expected[member][row]),
        actual=_shown(log[member][row]),
    )


def _shown(value: np.generic) -> str:
    if isinstance(value, np.floating):
        return f"{value!s} (0x{value.view(np.uint32):08x})"
    return str(value)
