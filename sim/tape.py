"""The inputs of each control step of a log, a list for each input, for the reference model.

A log is read once, column by column, because reading each number from its row would take longer
than the model's computation.
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
"""Columns of a log with counts that wrap around at 256."""


class Tape:
    """The inputs, by row.

    begins -- whether the row is the first after a reset; acknowledged, started -- acknowledgements
    and starts of a tuning since the row before; orders -- the other inputs, without a lost master.
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
        """The commands for each step; made at first use, as not every caller needs them."""
        log = self._log
        usual = {field: repeat(each, len(log)) for field, each in NO_ORDERS._asdict().items()}
        given = _given(log, log.dtype.names or ())
        return list(map(Orders, *(usual | given).values()))


def _singles(column: NDArray[Any]) -> list[Single]:
    return list(column.astype(np.float32, copy=False))


def count_in(row: np.void, count: str) -> int:
    """Return a count since the reset; 0 if the log does not have it."""
    return int(row[count]) if count in (row.dtype.names or ()) else 0


def _passed(log: StepLog, count: str) -> list[int]:
    """Return the increase of a count since the row before; 0 if the log does not have it."""
    if count not in (log.dtype.names or ()):
        return [0] * len(log)
    counts = log[count].astype(np.uint8)
    return np.diff(counts, prepend=counts[:1]).tolist()  # type: ignore[no-any-return]


def _given(log: StepLog, names: tuple[str, ...]) -> dict[str, Iterable[Any]]:
    """Return the commands in the log, by their fields; not every loop has all of them."""
    code = log["fault.code"]
    watched = np.where(np.isin(code, WATCHED_FAULTS), code, 0)
    plain = {"enabled": "enabled", "paused": "paused", "current_raw": "current.raw"}
    given: dict[str, Iterable[Any]] = {"watch_fault": watched.tolist()}
    given |= {field: log[name].tolist() for field, name in plain.items() if name in names}
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
    warning = (name.removesuffix(".warns") for name in names if name.endswith(".warns"))
    monitors = {
        each.removeprefix("monitor_"): _pairs(log, f"{each}.reading_status", f"{each}.reading_raw")
        for each in warning
    }
    return given | _each("numbers", numbers) | _each("monitors", monitors)


def _pairs(log: StepLog, one: str, other: str) -> Iterable[tuple[int, int]]:
    return zip(log[one].tolist(), log[other].tolist(), strict=True)


def _each(field: str, columns: Mapping[str, Iterable[Any]]) -> dict[str, Iterable[Any]]:
    """Convert a dictionary of columns to a dictionary for each row."""
    if not columns:
        return {}
    rows = zip(*columns.values(), strict=True)
    return {field: [dict(zip(columns, row, strict=True)) for row in rows]}
