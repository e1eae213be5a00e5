"""What went into each control step of a log, a list for each input: for the reference model.

A log is read column by column, once; to take each number from its row takes longer than the model
does with it.
"""

from collections.abc import Iterable, Mapping
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.reference.inputs import NO_ORDERS, Gains, Limits, Orders
from heatwright.sim.reference.loop import WATCHED_FAULTS
from heatwright.sim.reference.numbers import Single
from heatwright.sim.trace import StepLog
from heatwright.spec.adjusted import KINDS

ACKNOWLEDGEMENTS = "fault.acknowledgements"
STARTS = "autotune.starts"
"""Columns of counts of 8 bits."""


class Tape:
    """The inputs, by row.

    begins -- whether it is the first after a reset; acknowledged, started -- how often a fault was,
    and a tuning, since the row before; orders -- without a lost master.
    """

    def __init__(self, log: StepLog) -> None:
        """Read a log with one row or more."""
        self._log, steps = log, log["steps"]
        self.begins: list[bool] = [True, *((steps[1:] == 1) & (steps[:-1] != 0)).tolist()]
        self.acknowledged, self.started = _passed(log, ACKNOWLEDGEMENTS), _passed(log, STARTS)
        self.status: list[int] = log["reading_status"].tolist()
        self.raw: list[int] = log["reading_raw"].tolist()
        self.setpoint_c = _singles(log["setpoint_c"])
        self.fault_code: list[int] = log["fault.code"].tolist()

    @cached_property
    def orders(self) -> list[Orders]:
        """What else goes into each step; not everybody asks."""
        log = self._log
        usual = {field: repeat(each, len(log)) for field, each in NO_ORDERS._asdict().items()}
        given = _given(log, log.dtype.names or ())
        return list(map(Orders, *(usual | given).values()))


def _singles(column: NDArray[Any]) -> list[Single]:
    return list(column.astype(np.float32, copy=False))


def count_in(row: np.void, count: str) -> int:
    """Return a count since the reset; 0 if the log has none."""
    return int(row[count]) if count in (row.dtype.names or ()) else 0


def _passed(log: StepLog, count: str) -> list[int]:
    """Return by how much a count has gone on since the row before; 0 if the log has none."""
    if count not in (log.dtype.names or ()):
        return [0] * len(log)
    counts = log[count].astype(np.uint8)
    return np.diff(counts, prepend=counts[:1]).tolist()  # type: ignore[no-any-return]


def _given(log: StepLog, names: tuple[str, ...]) -> dict[str, Iterable[Any]]:
    """Return what the log has of the orders, by their fields: those that not every loop has."""
    code = log["fault.code"]
    watched = np.where(np.isin(code, WATCHED_FAULTS), code, 0)
    given: dict[str, Iterable[Any]] = {"watch_fault": watched.tolist()}
    if "enabled" in names:
        given["enabled"] = log["enabled"].tolist()
    if "paused" in names:
        given["paused"] = log["paused"].tolist()
    if "current.raw" in names:
        given["current_raw"] = log["current.raw"].tolist()
    if "guard.maximum_c" in names:
        given["maximum_c"] = _singles(log["guard.maximum_c"])
    if "program.order" in names:
        given["program"] = _pairs(log, "program.order", "program.argument")
    if "mode" in names:
        given["mode"] = log["mode"].tolist()
        given["manual_percent"] = _singles(log["manual_percent"])
        given["gains"] = map(Gains, *(_singles(log[f"algorithm.{gain}"]) for gain in Gains._fields))
    if "output_maximum_percent" in names:
        limits = (_singles(log[f"{limit}_percent"]) for limit in Limits._fields)
        given["limits"] = map(Limits, *limits)
    keyed = {kind.field: f"algorithm.{kind.field}" for kind in KINDS}
    numbers = {field: _singles(log[name]) for field, name in keyed.items() if name in names}
    monitors = {
        name.partition(".")[0].removeprefix("monitor_"): _readings(log, name.partition(".")[0])
        for name in names
        if name.endswith(".warns")
    }
    return given | _each("numbers", numbers) | _each("monitors", monitors)


def _readings(log: StepLog, monitor: str) -> Iterable[tuple[int, int]]:
    return _pairs(log, f"{monitor}.reading_status", f"{monitor}.reading_raw")


def _pairs(log: StepLog, one: str, other: str) -> Iterable[tuple[int, int]]:
    return zip(log[one].tolist(), log[other].tolist(), strict=True)


def _each(field: str, columns: Mapping[str, Iterable[Any]]) -> dict[str, Iterable[Any]]:
    """Make a dictionary for each row of a dictionary of columns."""
    if not columns:
        return {}
    rows = zip(*columns.values(), strict=True)
    return {field: [dict(zip(columns, row, strict=True)) for row in rows]}
