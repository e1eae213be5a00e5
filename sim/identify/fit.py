"""The machine nearest to a record, by nonlinear least squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from heatwright.sim.identify.answer import LEAST_LAG_S, Answer, modes
from heatwright.sim.identify.record import Record
from heatwright.sim.identify.residuals import outliers
from heatwright.sim.identify.search import Beginning, Search, beginnings
from heatwright.sim.identify.structure import Structure
from heatwright.sim.identify.surety import Surety, surety
from heatwright.sim.identify.unusable import Unusable
from heatwright.sim.identify.verdict import Found, findings, warnings
from heatwright.sim.trace import Series

__all__ = ["Found", "Identified", "fit"]

Progress = Callable[[float, float], None]
"""Called with how many fits are done, and how many there are."""


@dataclass(frozen=True)
class Identified:
    """What was found, and how well it fits."""

    record: Record
    structure: Structure
    values: Series
    """Parameters in the order of the structure's."""
    found: tuple[Found, ...]
    """The same, with how sure they are."""
    model_c: Series
    """What the machine found would have read, at the rows of the record."""
    left_out: NDArray[np.bool_]
    """Rows whose readings no machine could give, and that were left out of the fit."""
    rms_k: float
    noise_k: float
    """What differs from one reading to the next, without pattern."""
    warnings: tuple[str, ...]

    @property
    def residuals_k(self) -> Series:
        """Reading minus model where the fit looked, K."""
        kept = ~self.left_out
        return np.asarray(self.record.readings_c[kept] - self.model_c[kept])

    @property
    def worst_k(self) -> float:
        """Largest distance between reading and model, K."""
        return float(np.abs(self.residuals_k).max())

    @property
    def percent(self) -> float:
        """How much of the readings' movement the model tells: 100 % is all."""
        readings_c = self.record.readings_c[~self.left_out]
        return float(100 * (1 - self.rms_k / readings_c.std()))


def fit(
    record: Record,
    structure: Structure,
    *,
    ambient_c: float | None = None,
    age_s: float = 0.0,
    progress: Progress | None = None,
) -> Identified:
    """Fit a machine to a record.

    Args:
        record: times, readings, power.
        structure: the machine that is looked for.
        ambient_c: temperature of the surroundings if it is known, °C; else it is found too.
        age_s: how old a reading is when it is logged, s.
        progress: told of the fits.

    Raises:
        Unusable: no machine with a heater that heats comes near the record.

    """
    fitting = _Fitting(record, structure, ambient_c, age_s)
    best = fitting.best(progress)
    wrong = outliers(best.residuals_k, record.resolution_k)
    if wrong.any():
        fitting = _Fitting(record.without(wrong), structure, ambient_c, age_s, best.before_w)
        best = fitting.again(best)
    return _identified(fitting, best, record, wrong)


@dataclass(frozen=True)
class _Solution:
    vector: Series
    before_w: float
    residuals_k: Series
    """NaN where a reading was left out."""
    cost: float
    jacobian: NDArray[np.float64]


class _Fitting:
    """A record under one structure; the vector is parameters, then temperatures at the start."""

    def __init__(
        self,
        record: Record,
        structure: Structure,
        ambient_c: float | None,
        age_s: float,
        before_w: float | None = None,
    ) -> None:
        self.record, self.structure, self.age_s = record, structure, age_s
        self._ambient_c = ambient_c
        first_w = float(record.powers_w[0])
        # The heater may have been switched on by the first row, or long before it.
        self._before = (before_w,) if before_w is not None else tuple({0.0: 0, first_w: 0})
        self._logarithmic = np.array(
            [each.logarithmic for each in structure.parameters] + [False] * structure.states
        )

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Which numbers of the vector are looked for."""
        free = np.ones(len(self._logarithmic), dtype=bool)
        free[len(self.structure.parameters) - 1] = self._ambient_c is None
        return free

    def values(self, vector: Series) -> tuple[Series, Series]:
        """Split a vector into parameters and start."""
        plain = vector.copy()
        plain[self._logarithmic] = np.exp(vector[self._logarithmic])
        count = len(self.structure.parameters)
        return plain[:count], plain[count:]

    def vector(self, values: Series, start_c: Series) -> Series:
        """Join parameters and start."""
        joined = np.concatenate((values, start_c))
        joined[self._logarithmic] = np.log(joined[self._logarithmic])
        return joined

    def best(self, progress: Progress | None) -> _Solution:
        """Fit from every beginning and keep the best."""
        starts = [
            (before_w, each)
            for before_w in self._before
            for each in beginnings(
                self.record, self.structure, before_w, self.age_s, self._ambient_c
            )
        ]
        if not starts:
            raise Unusable(
                "gets no warmer from its heater: no machine fits. Are duty and temperature the "
                "right columns (--columns)?"
            )
        found = []
        for number, (before_w, each) in enumerate(starts, 1):
            found.append(self._solve(before_w, each))
            if progress is not None:
                progress(number, len(starts))
        return self._ordered(min(found, key=lambda each: each.cost))

    def again(self, solution: _Solution) -> _Solution:
        """Fit once more from a solution."""
        values, start_c = self.values(solution.vector)
        return self._solve(solution.before_w, Beginning(values, start_c, solution.cost))

    def _ordered(self, solution: _Solution) -> _Solution:
        """Make the lag the shorter one of the two time constants.

        A body and a lag cannot be told apart by their order: both ways answer alike.
        """
        values, _ = self.values(solution.vector)
        cooling_s, lag_s = self.structure.cooling_s(values), float(values[-3])
        if self.structure.bodies > 1 or lag_s <= cooling_s:
            return solution
        shape = np.array([lag_s, 1.0, cooling_s, values[-2], 0.0])
        search = Search(self.record, self.structure, solution.before_w, self.age_s, self._ambient_c)
        swapped = search.linear(shape)
        return solution if swapped is None else self._solve(solution.before_w, swapped)

    def _solve(self, before_w: float, start: Beginning) -> _Solution:
        answer = Answer(self.record, before_w)
        seen = np.isfinite(self.record.readings_c)
        whole = self.vector(start.values, start.start_c)
        free, names = self.free, self.structure.names

        def residuals(chosen: Series) -> Series:
            whole[free] = chosen
            values, start_c = self.values(whole)
            found = modes(self.structure.network(values), names.heater, names.sensor)
            late_s = float(values[-2]) + self.age_s
            model_c = answer.readings(found, late_s, float(values[-1]), start_c)
            return np.asarray((self.record.readings_c - model_c)[seen])

        low, high = self._bounds()
        inside = np.clip(whole[free], low[free], high[free])
        result: OptimizeResult = least_squares(
            residuals,
            inside,
            jac="3-point",
            bounds=(low[free], high[free]),
            x_scale="jac",
            max_nfev=300,
        )
        whole[free] = result.x
        full_k = np.full(self.record.rows, np.nan)
        full_k[seen] = result.fun
        return _Solution(whole.copy(), before_w, full_k, float(result.cost), result.jac)

    def _bounds(self) -> tuple[Series, Series]:
        low = np.full(len(self._logarithmic), -np.inf)
        high = np.full(len(self._logarithmic), np.inf)
        place = len(self.structure.parameters) - 3
        low[place], low[place + 1] = LEAST_LAG_S, 0.0
        high[place + 1] = self.record.duration_s
        return low, high


def _identified(
    fitting: _Fitting, best: _Solution, record: Record, wrong: NDArray[np.bool_]
) -> Identified:
    values, start_c = fitting.values(best.vector)
    names = fitting.structure.names
    found = modes(fitting.structure.network(values), names.heater, names.sensor)
    model_c = Answer(record, best.before_w).readings(
        found, float(values[-2]) + fitting.age_s, float(values[-1]), start_c
    )
    residuals_k = best.residuals_k[np.isfinite(best.residuals_k)]
    sure: Surety = surety(best.jacobian, residuals_k, fitting.free)
    told = findings(fitting.structure, values, sure, record, ambient_given=not fitting.free.all())
    return Identified(
        record=record,
        structure=fitting.structure,
        values=values,
        found=told,
        model_c=model_c,
        left_out=wrong,
        rms_k=float(np.sqrt((residuals_k**2).mean())),
        noise_k=sure.noise_k,
        warnings=(*warnings(told, residuals_k, record, fitting.structure), *_left_out(wrong)),
    )


def _left_out(wrong: NDArray[np.bool_]) -> tuple[str, ...]:
    if not wrong.any():
        return ()
    return (
        f"{int(wrong.sum())} single readings stand out so far that they are taken for garbled and "
        "left out of the fit",
    )
