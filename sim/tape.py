"""The inputs of each control step of a log, a list for each input, for the reference model.

A log is read once, column by column, because reading each number from its row would take longer
than the model's computation.
"""

from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.reference.inputs import NO_ORDERS, Gains, Limits, Orders
from heatwright.sim.reference.loop import WATCHED_FAULTS
from heatwright.sim.trace import StepLog
from heatwright.spec.adjusted import KINDS

ACKNOWLEDGEMENTS = "fault.acknowledgements"
STARTS = "autotune.starts"
"""Columns of a log with counts that wrap around at 256."""
MOST_AT_ONCE = 20_000
"""Longest series of rows; longer ones would need too much memory."""


class Tape:
    """The inputs, by row.

    begins -- whether the row is the first after a reset; acknowledged, started -- acknowledgements
    and starts of a tuning since the row before.
    """

    def __init__(self, log: StepLog) -> None:
        """Read a log with one row or more."""
        self._log, steps = log, log["steps"]
        self.begins: list[bool] = [True, *((steps[1:] == 1) & (steps[:-1] != 0)).tolist()]
        self.acknowledged, self.started = _passed(log, ACKNOWLEDGEMENTS), _passed(log, STARTS)
        self.status: list[int] = log["reading_status"].tolist()
        self.raw: list[int] = log["reading_raw"].tolist()
        self.setpoint_c = _rows(log["setpoint_c"])
        self.fault_code: list[int] = log["fault.code"].tolist()

    def orders(self, first: int, end: int) -> list[Orders]:
        """Return the other inputs of some rows, without a lost master."""
        usual = {field: repeat(each, end - first) for field, each in NO_ORDERS._asdict().items()}
        given = {field: _rows(each) for field, each in commands_in(self._log[first:end]).items()}
        return list(map(Orders, *(usual | given).values()))

    def usual(self) -> list[tuple[int, int]]:
        """Return series of rows in which only readings and commands are new.

        Each series is given by its first row and the row after its last. None of its rows has a
        reset, an acknowledgement, the start of a tuning, or a command to a program; and neither
        the program's state nor the fault changes.
        """
        log, names = self._log, self._log.dtype.names or ()
        special = np.array(self.begins) | (np.array(self.acknowledged) > 0)
        special |= np.array(self.started) > 0
        if "program.order" in names:
            special |= log["program.order"] > 0
        for state in {"fault.code", "program.state"}.intersection(names):
            special[1:] |= log[state][1:] != log[state][:-1]
        edges = np.flatnonzero(np.diff(special, prepend=True, append=True))
        return [
            (begin, min(begin + MOST_AT_ONCE, end))
            for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
            for begin in range(first, end, MOST_AT_ONCE)
        ]


def count_in(row: np.void, count: str) -> int:
    """Return a count since the reset; 0 if the log does not have it."""
    return int(row[count]) if count in (row.dtype.names or ()) else 0


def _passed(log: StepLog, count: str) -> list[int]:
    """Return the increase of a count since the row before; 0 if the log does not have it."""
    if count not in (log.dtype.names or ()):
        return [0] * len(log)
    counts = log[count].astype(np.uint8)
    return np.diff(counts, prepend=counts[:1]).tolist()  # type: ignore[no-any-return]


def commands_in(log: StepLog) -> dict[str, Any]:
    """Return the commands in the log, by their fields in `Orders`, with a column for each number.

    Not every loop has all of them.
    """
    names = log.dtype.names or ()
    code = numbers_in(log, "fault.code")
    plain = {
        "enabled": "enabled", "paused": "paused", "current_raw": "current.raw", "mode": "mode",
        "manual_percent": "manual_percent", "maximum_c": "guard.maximum_c",
    }  # fmt: skip
    given: dict[str, Any] = {"watch_fault": np.where(np.isin(code, WATCHED_FAULTS), code, 0)}
    given |= {field: numbers_in(log, name) for field, name in plain.items() if name in names}
    if "program.order" in names:
        given["program"] = tuple(numbers_in(log, f"program.{of}") for of in ("order", "argument"))
    if "mode" in names:
        given["gains"] = Gains._make(numbers_in(log, f"algorithm.{gain}") for gain in Gains._fields)
    if "output_maximum_percent" in names:
        given["limits"] = Limits._make(
            numbers_in(log, f"{each}_percent") for each in Limits._fields
        )
    keyed = {kind.field: f"algorithm.{kind.field}" for kind in KINDS}
    numbers = {field: numbers_in(log, name) for field, name in keyed.items() if name in names}
    warning = [name.removesuffix(".warns") for name in names if name.endswith(".warns")]
    monitors = {
        each.removeprefix("monitor_"): tuple(
            numbers_in(log, f"{each}.reading_{of}") for of in ("status", "raw")
        )
        for each in warning
    }
    each = {"numbers": numbers, "monitors": monitors}
    return given | {field: columns for field, columns in each.items() if columns}


def numbers_in(log: StepLog, name: str) -> NDArray[Any]:
    """Return a column as the reference model's numbers: float32, or integers of any size."""
    column = log[name]
    return column.astype(np.float32 if column.dtype.kind == "f" else np.int64)


def _rows(columns: Any) -> list[Any]:
    """Return one value for each row from columns, also in tuples and dictionaries of columns."""
    if isinstance(columns, dict):
        rows = zip(*map(_rows, columns.values()), strict=True)
        return [dict(zip(columns, row, strict=True)) for row in rows]
    if isinstance(columns, tuple):
        rows = zip(*map(_rows, columns), strict=True)
        return list(map(columns._make, rows) if hasattr(columns, "_make") else rows)
    return list(columns) if columns.dtype.kind == "f" else columns.tolist()
