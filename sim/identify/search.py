"""Where to begin: a coarse search over time constants, the rest by linear least squares.

For given time constants the reading is linear in the gain, the ambient and the temperatures at the
start. So only a few shapes of the answer have to be tried (separable least squares: Golub &
Pereyra, SIAM Journal on Numerical Analysis 10, 1973).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from heatwright.sim.identify.answer import Answer, modes
from heatwright.sim.identify.record import Record
from heatwright.sim.identify.structure import Structure
from heatwright.sim.trace import Series

MOST_ROWS = 400
"""Readings that are looked at; more do not make a coarse search finer."""

TIMES = 14
LAGS = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 0.8)
DELAYS = (0.0, 0.003, 0.01, 0.03, 0.1)
"""Lags and dead times tried, as shares of the main time constant."""

SPLITS = ((0.2, 0.3), (0.2, 1.0), (1.0, 0.3), (1.0, 1.0), (5.0, 0.3), (5.0, 1.0))
"""For two bodies: capacity and resistance of the outer one over those of the inner one."""

KEPT = 3
"""Beginnings that are worth a fit each."""


class Beginning(NamedTuple):
    """Parameters to start from, and the sum of squares there, K²."""

    values: Series
    start_c: Series
    cost: float


def beginnings(
    record: Record, structure: Structure, before_w: float, age_s: float, ambient_c: float | None
) -> list[Beginning]:
    """Return the best shapes, best first."""
    search = Search(record, structure, before_w, age_s, ambient_c)
    found = [
        beginning
        for shape in _shapes(record, structure)
        if (beginning := search.linear(shape)) is not None
    ]
    return sorted(found, key=lambda each: each.cost)[:KEPT]


class Search:
    """A thinned record, ready to try shapes on."""

    def __init__(
        self,
        record: Record,
        structure: Structure,
        before_w: float,
        age_s: float,
        ambient_c: float | None,
    ) -> None:
        seen = np.flatnonzero(np.isfinite(record.readings_c))
        rows = seen[:: max(1, len(seen) // MOST_ROWS)]
        off = replace(record, powers_w=np.zeros(record.rows))
        self._readings_c = record.readings_c[rows]
        self._structure = structure
        self._heated = Answer(record, before_w, rows)
        self._quiet = Answer(off, 0.0, rows)
        self._age_s = age_s
        self._ambient_c = ambient_c

    def linear(self, shape: Series) -> Beginning | None:
        """Find gain, ambient and start for the time constants of a shape; None if it is absurd."""
        structure = self._structure
        names = structure.names
        found = modes(structure.network(shape), names.heater, names.sensor)
        late_s = float(shape[-2]) + self._age_s
        rest = np.zeros(structure.states)
        columns = [self._heated.readings(found, late_s, 0.0, rest)]
        target_c = self._readings_c
        surroundings = self._quiet.readings(found, late_s, 1.0, rest)
        if self._ambient_c is None:
            columns.append(surroundings)
        else:
            target_c = target_c - surroundings * self._ambient_c
        columns += [
            self._quiet.readings(found, late_s, 0.0, unit) for unit in np.eye(structure.states)
        ]
        matrix = np.column_stack(columns)
        weights, *_ = np.linalg.lstsq(matrix, target_c, rcond=None)
        gain = float(weights[0])
        if gain <= 0:
            return None
        values = shape.copy()
        values[0 : 2 * structure.bodies : 2] /= gain
        values[1 : 2 * structure.bodies : 2] *= gain
        values[-1] = weights[1] if self._ambient_c is None else self._ambient_c
        cost = float(((matrix @ weights - target_c) ** 2).sum())
        return Beginning(values, np.asarray(weights[-structure.states :], dtype=np.float64), cost)


def _shapes(record: Record, structure: Structure) -> Iterator[Series]:
    """Yield parameters with a gain of 1 K/W."""
    span_s = record.duration_s
    shortest_s = span_s / MOST_ROWS
    for time_s in np.geomspace(shortest_s, 30 * span_s, TIMES).tolist():
        for lag, delay in product(LAGS, DELAYS):
            rest = (lag * time_s, delay * time_s, 0.0)
            if delay * time_s > span_s / 2:
                continue
            if structure.bodies == 1:
                yield np.array([time_s, 1.0, *rest])
                continue
            for capacity, resistance in SPLITS:
                inner = time_s / ((1 + capacity) * (1 + resistance))
                yield np.array([inner, 1.0, capacity * inner, resistance, *rest])
