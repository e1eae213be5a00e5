"""A record of time, temperature and power, made from a log and its units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.identify.columns import Column, Roles
from heatwright.sim.identify.log import DAY_S, Log, Unusable, unwrapped
from heatwright.sim.trace import Series

FEWEST_ROWS = 10
"""The model has seven parameters; fewer rows could not show how well they fit."""

_SECONDS: Mapping[str, float] = {
    "": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0,
}  # fmt: skip
_WATTS: Mapping[str, float] = {"": 1.0, "W": 1.0, "mW": 1e-3, "kW": 1e3}
_FULL: Mapping[str, float] = {"%": 100.0, "1": 1.0}
HOTTEST_C, COLDEST_C = 5000.0, -273.15


@dataclass(frozen=True)
class Scales:
    """Values that a log does not contain."""

    power_w: float | None = None
    """Power of the heater at full duty, W."""
    full: float | None = None
    """Number in the duty's column that means full power."""
    every_s: float | None = None
    """Time between two rows, s, if the log has no times."""


@dataclass(frozen=True)
class Record:
    """Readings, and the power from each row to the next."""

    times_s: Series
    """Times of the readings, s: from 0, ascending."""
    readings_c: Series
    powers_w: Series
    """Each power lasts from its row to the next."""
    notes: tuple[str, ...] = field(default=())
    """Notes for the user: what was assumed or left out."""

    @property
    def rows(self) -> int:
        """How many readings there are."""
        return len(self.times_s)

    @property
    def duration_s(self) -> float:
        """Time from the first reading to the last, s."""
        return float(self.times_s[-1])

    @property
    def steps(self) -> tuple[tuple[float, float, float], ...]:
        """Changes of the power: time, s, and power before and after it, W."""
        places = np.flatnonzero(np.diff(self.powers_w)) + 1
        return tuple(
            (float(self.times_s[k]), float(self.powers_w[k - 1]), float(self.powers_w[k]))
            for k in places
        )

    @property
    def resolution_k(self) -> float:
        """Smallest difference of two readings, K: the sensor's step, or the log's last digit."""
        levels = np.unique(self.readings_c)
        # Smaller gaps are only rounding errors of decimal numbers.
        gaps = np.diff(levels)
        gaps = gaps[gaps > 1e-9 * max(1.0, float(np.abs(levels).max()))]
        return float(gaps.min()) if len(gaps) else 0.0

    def without(self, rows: NDArray[np.bool_]) -> Record:
        """Return the record without some readings, but with all of the power."""
        return Record(self.times_s, np.where(rows, np.nan, self.readings_c), self.powers_w)


def record_of(log: Log, roles: Roles, scales: Scales) -> Record:
    """Make a record of a log.

    Raises Unusable: something is missing, or the record cannot determine a plant.
    """
    notes: list[str] = []
    times_s, readings_c, powers_w = tabled(log, roles, scales, notes)
    good = np.isfinite(readings_c) & np.isfinite(powers_w) & np.isfinite(times_s)
    good &= (readings_c > COLDEST_C) & (readings_c < HOTTEST_C)
    left_out = log.dropped + int((~good).sum())
    if left_out:
        notes.append(f"lines of the log that were no readings: {left_out}")
    part = _longest(times_s[good], readings_c[good], powers_w[good], notes)
    record = Record(*part, notes=tuple(notes))
    _check(record)
    return record


def tabled(
    log: Log, roles: Roles, scales: Scales, notes: list[str]
) -> tuple[Series, Series, Series]:
    """Return times, s, readings, °C, and powers, W, of all rows; gaps are NaN. Raises Unusable."""
    return (
        _times(log.values, roles.time, scales),
        _celsius(log.values, roles.temperature),
        _powers(log.values, roles, scales, notes),
    )


def _celsius(values: Series, column: Column) -> Series:
    readings = values[:, column.place]
    if column.unit in {"°F", "F", "degF"}:
        return np.asarray((readings - 32.0) * 5.0 / 9.0)
    return readings - 273.15 if column.unit == "K" else readings


def _times(values: Series, column: Column | None, scales: Scales) -> Series:
    if column is None:
        if scales.every_s is None:
            raise Unusable("has no times; give the time between its lines, such as --period 1s")
        return np.arange(len(values), dtype=np.float64) * scales.every_s
    seconds = _SECONDS.get(column.unit)
    if seconds is None:
        raise Unusable(f"has times in {column.unit}; s, ms, min and h can be read")
    times_s = values[:, column.place] * seconds
    known = times_s[np.isfinite(times_s)]
    if len(known) and known.min() >= 0 and known.max() < DAY_S:  # times of day may pass midnight
        return unwrapped(times_s)
    return times_s


def _powers(values: Series, roles: Roles, scales: Scales, notes: list[str]) -> Series:
    if roles.power is not None and (roles.duty is None or scales.power_w is None):
        factor = _WATTS.get(roles.power.unit)
        if factor is None:
            raise Unusable(f"has a power in {roles.power.unit}; W, mW and kW can be read")
        return _not_negative(values[:, roles.power.place] * factor, "power")
    assert roles.duty is not None  # noqa: S101 - columns.py requires one of both
    if scales.power_w is None:
        raise Unusable("has the duty, not the power; say what full duty is, such as --power 40W")
    duty = values[:, roles.duty.place]
    full = scales.full or _FULL.get(roles.duty.unit) or _guessed(duty, notes)
    share = _not_negative(duty / full, "duty")
    if np.nanmax(share) > 1:
        most = float(np.nanmax(duty))
        raise Unusable(
            f"has a duty of {most:g} where {full:g} is full power; say which number is full power, "
            "such as --full 255"
        )
    return share * scales.power_w


def _guessed(duty: Series, notes: list[str]) -> float:
    """Return the duty of full power: 1 for duties up to 1, otherwise 100."""
    full = 1.0 if np.nanmax(duty, initial=0.0) <= 1 else 100.0
    notes.append(f"full power is taken to be a duty of {full:g} (--full says otherwise)")
    return full


def _not_negative(values: Series, what: str) -> Series:
    if np.nanmin(values, initial=0.0) < 0:
        raise Unusable(f"has a {what} below 0; this model heats only. Is it the right column?")
    return values


def _longest(
    times_s: Series, readings_c: Series, powers_w: Series, notes: list[str]
) -> tuple[Series, Series, Series]:
    """Return the longest part with ascending times; of rows with the same time, the last one."""
    if not len(times_s):
        return times_s, readings_c, powers_w
    starts = [0, *(np.flatnonzero(np.diff(times_s) < 0) + 1).tolist(), len(times_s)]
    parts = [slice(a, b) for a, b in pairwise(starts)]
    if len(parts) > 1:
        notes.append(
            f"time goes back {len(parts) - 1} times in the log, as after a reset; its longest part "
            "is used"
        )
    part = max(parts, key=lambda each: float(times_s[each.stop - 1] - times_s[each.start]))
    times, readings, powers = times_s[part], readings_c[part], powers_w[part]
    last = np.append(np.diff(times) > 0, True)
    return times[last] - times[last][0], readings[last], powers[last]


def _check(record: Record) -> None:
    if record.rows < FEWEST_ROWS:
        raise Unusable(
            f"has {record.rows} readings in a row; at least {FEWEST_ROWS} are needed, and a few "
            "hundred are better"
        )
    if record.powers_w.max() == 0:
        raise Unusable(
            "never has the heater on, and cooling alone does not show the heat capacity. "
            "Record a step: heater off, then on"
        )
    if np.ptp(record.readings_c) == 0:
        raise Unusable(
            "has the same temperature in every line. Is it the right column (--columns)?"
        )
