"""Start values of a fit: a coarse search over time constants, the rest by linear least squares.

For given time constants the reading is linear in the gain, the ambient and the temperatures at the
start. So only a few shapes of the response have to be tried (separable least squares: Golub &
Pereyra, SIAM Journal on Numerical Analysis 10, 1973).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.identify.answer import Answer, modes
from heatwright.sim.identify.record import Record
from heatwright.sim.identify.structure import Structure
from heatwright.sim.trace import Series

SEARCHED_ROWS = 400
"""Number of readings used; more would not improve a coarse search."""

TIMES = 14
LAGS = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 0.8)
DELAYS = (0.0, 0.003, 0.01, 0.03, 0.1)
"""Lags and dead times tried, as shares of the main time constant."""

FEW_LAGS, FEW_DELAYS = (0.0, 0.01, 0.1), (0.0, 0.01)
"""Lags and dead times tried with two bodies: fewer, because there are more shapes to try."""

SPLITS = ((0.2, 0.3), (0.2, 1.0), (1.0, 0.3), (1.0, 1.0), (5.0, 0.3), (5.0, 1.0))
"""For two bodies: capacity and resistance of the outer one over those of the inner one."""

KEPT = 3
"""Number of best start values that are each fitted."""


@dataclass(frozen=True)
class Setting:
    """The assumptions of a fit."""

    record: Record
    structure: Structure
    age_s: float
    """How old a reading is when it is logged, s."""
    ambient_c: float | None
    """None: it is fitted."""
    before_w: float = 0.0
    """Power before the record, W."""
    rest: bool = False
    """Whether the machine was in the steady state of that power when the record began."""

    @property
    def seen(self) -> NDArray[np.intp]:
        """Rows that have a reading."""
        return np.flatnonzero(np.isfinite(self.record.readings_c))

    def thinned(self, most: int) -> NDArray[np.intp]:
        """Choose roughly `most` of the rows in `seen`, evenly spaced."""
        seen = self.seen
        return seen[:: max(1, len(seen) // most)]


class Beginning(NamedTuple):
    """Parameters to start from, and the sum of squares there, K²."""

    values: Series
    start_c: Series
    cost: float
    heats: bool = True
    """False: the heater would have to cool the machine; the other members are then meaningless."""


def beginnings(setting: Setting) -> list[Beginning]:
    """Return the best start values, best first; none if a heater that cools would fit better."""
    search = Search(setting)
    found = sorted(
        (search.linear(shape) for shape in _shapes(setting.record, setting.structure)),
        key=lambda each: each.cost,
    )
    return [each for each in found if each.heats][:KEPT] if found[0].heats else []


class Search:
    """A thinned record, prepared to test shapes of the response."""

    def __init__(self, setting: Setting) -> None:
        record, rows = setting.record, setting.thinned(SEARCHED_ROWS)
        off = replace(record, powers_w=np.zeros(record.rows))
        self._setting = setting
        self._readings_c = record.readings_c[rows]
        self._heated = Answer(record, setting.before_w, rows)
        self._quiet = Answer(off, 0.0, rows)

    def linear(self, shape: Series) -> Beginning:
        """Fit gain, ambient and start for the time constants of a shape."""
        setting = self._setting
        columns, surroundings = self._columns(shape)
        target_c = self._readings_c
        if setting.ambient_c is None:
            columns.insert(1, surroundings)
        else:
            target_c = target_c - surroundings * setting.ambient_c
        matrix = np.column_stack(columns)
        weights, *_ = np.linalg.lstsq(matrix, target_c, rcond=None)
        cost = float(((matrix @ weights - target_c) ** 2).sum())
        gain = float(weights[0])
        if gain <= 0:
            return Beginning(shape, shape, cost, heats=False)
        values, size = shape.copy(), 2 * setting.structure.bodies
        values[0:size:2] /= gain
        values[1:size:2] *= gain
        values[-1] = weights[1] if setting.ambient_c is None else setting.ambient_c
        states = setting.structure.states
        start_c = np.full(states, values[-1]) if setting.rest else weights[-states:].copy()
        return Beginning(values, np.asarray(start_c, dtype=np.float64), cost)

    def _columns(self, shape: Series) -> tuple[list[Series], Series]:
        """Return the responses to the power, to each start temperature, and to the ambient."""
        setting, structure = self._setting, self._setting.structure
        names = structure.names
        found = modes(structure.network(shape), names.heater, names.sensor)
        late_s = float(shape[-2]) + setting.age_s
        if setting.rest:
            heated = self._heated.readings(found, late_s, 0.0, None)
            return [heated], np.ones(len(heated))
        rest = np.zeros(structure.states)
        heated = self._heated.readings(found, late_s, 0.0, rest)
        starts = [
            self._quiet.readings(found, late_s, 0.0, unit) for unit in np.eye(structure.states)
        ]
        return [heated, *starts], self._quiet.readings(found, late_s, 1.0, rest)


def _shapes(record: Record, structure: Structure) -> Iterator[Series]:
    """Yield the parameters to try; the resistance of the inner body, or only one, is 1 K/W."""
    span_s = record.duration_s
    shortest_s = span_s / SEARCHED_ROWS
    choices = (LAGS, DELAYS) if structure.bodies == 1 else (FEW_LAGS, FEW_DELAYS)
    for time_s in np.geomspace(shortest_s, 30 * span_s, TIMES).tolist():
        for lag, delay in product(*choices):
            rest = (lag * time_s, delay * time_s, 0.0)
            if delay * time_s > span_s / 2:
                continue
            if structure.bodies == 1:
                yield np.array([time_s, 1.0, *rest])
                continue
            for capacity, resistance in SPLITS:
                inner = time_s / ((1 + capacity) * (1 + resistance))
                yield np.array([inner, 1.0, capacity * inner, resistance, *rest])
