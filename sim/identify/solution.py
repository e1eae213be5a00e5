"""Nonlinear least squares on a record, under one setting."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from heatwright.sim.identify.answer import LEAST_LAG_S, Answer, modes
from heatwright.sim.identify.search import Beginning, Search, Setting
from heatwright.sim.trace import Series
from heatwright.spec.units import CAPACITY, DURATION, THERMAL_RESISTANCE

MOST_EVALUATIONS = 200
LEAST_CAPACITY, LEAST_RESISTANCE = 1e-3, 1e-6
"""The lowest values that a spec may have, J/K and K/W."""


@dataclass(frozen=True)
class Solution:
    """The result of a fit."""

    setting: Setting
    values: Series
    """Parameters in the order of the structure's."""
    start_c: Series
    """Temperatures at the start: of the bodies, and of the sensor."""
    residuals_k: Series
    """Residuals of the rows that were compared."""
    jacobian: NDArray[np.float64]
    free: NDArray[np.bool_]
    """Which parameters were fitted; the fitted start temperatures come after them."""

    @property
    def cost(self) -> float:
        """Sum of the squared residuals, K²."""
        return float((self.residuals_k**2).sum())

    @property
    def beginning(self) -> Beginning:
        """The solution as start values of another fit."""
        return Beginning(self.values, self.start_c, self.cost)

    def model_c(self) -> Series:
        """Return the model's readings at every row of the record."""
        rows = np.arange(self.setting.record.rows)
        return _Model(self.setting, Answer(self.setting.record, self.setting.before_w, rows))(
            self.values, self.start_c
        )


def solve(
    setting: Setting, start: Beginning, *, most_rows: int | None = None, exact: bool = True
) -> Solution:
    """Find the parameters with the least sum of squares.

    setting -- the record and the assumptions; start -- the start values; most_rows -- use only
    about this number of readings; exact -- compute slopes by central differences, as the intervals
    need; or by forward ones.
    """
    rows = setting.seen if most_rows is None else setting.thinned(most_rows)
    readings_c = setting.record.readings_c[rows]
    model = _Model(setting, Answer(setting.record, setting.before_w, rows))
    vector = _Vector(setting)
    whole = vector.join(start)

    def residuals(chosen: Series) -> Series:
        whole[vector.free] = chosen
        return np.asarray(readings_c - model(*vector.split(whole)))

    low, high = vector.bounds()
    result: OptimizeResult = least_squares(
        residuals,
        np.clip(whole[vector.free], low, high),
        jac="3-point" if exact else "2-point",
        bounds=(low, high),
        x_scale="jac",
        max_nfev=MOST_EVALUATIONS,
    )
    whole[vector.free] = result.x
    values, start_c = vector.split(whole)
    free = vector.free[: len(values)]
    return Solution(setting, values, start_c, result.fun, result.jac, free)


def ordered(solution: Solution) -> Solution:
    """Make the lag the shorter one of the two time constants.

    Body and lag may be swapped: the response is the same.
    """
    setting, values = solution.setting, solution.values
    cooling_s, lag_s = setting.structure.cooling_s(values), float(values[-3])
    if setting.structure.bodies > 1 or lag_s <= cooling_s:
        return solution
    swapped = Search(setting).linear(np.array([lag_s, 1.0, cooling_s, values[-2], 0.0]))
    return solve(setting, swapped) if swapped.heats else solution


class _Model:
    """Computes the plant's readings from parameters and the temperatures at the start."""

    def __init__(self, setting: Setting, answer: Answer) -> None:
        self._setting, self._answer = setting, answer

    def __call__(self, values: Series, start_c: Series) -> Series:
        setting, names = self._setting, self._setting.structure.names
        found = modes(setting.structure.network(values), names.heater, names.sensor)
        late_s = float(values[-2]) + setting.age_s
        return self._answer.readings(
            found, late_s, float(values[-1]), None if setting.rest else start_c
        )


class _Vector:
    """Parameters, then temperatures at the start, as one vector; positive numbers as logarithms."""

    def __init__(self, setting: Setting) -> None:
        parameters, states = setting.structure.parameters, setting.structure.states
        self._count = len(parameters)
        self._logarithmic = np.array([each.logarithmic for each in parameters] + [False] * states)
        self._longest_s = setting.record.duration_s
        self.free = np.ones(self._count + states, dtype=bool)
        self.free[self._count - 1] = setting.ambient_c is None
        self.free[self._count :] = not setting.rest

    def join(self, start: Beginning) -> Series:
        joined = np.concatenate((start.values, start.start_c))
        joined[self._logarithmic] = np.log(joined[self._logarithmic])
        return joined

    def split(self, vector: Series) -> tuple[Series, Series]:
        plain = vector.copy()
        plain[self._logarithmic] = np.exp(vector[self._logarithmic])
        return plain[: self._count], plain[self._count :]

    def bounds(self) -> tuple[Series, Series]:
        low = np.full(len(self.free), -np.inf)
        high = np.full(len(self.free), np.inf)
        lag, delay = self._count - 3, self._count - 2
        low[lag], low[delay] = LEAST_LAG_S, 0.0
        high[delay] = self._longest_s
        # The limits of a spec: 1 mJ/K and 1 µK/W up to the largest value of each dimension.
        bodies = (self._count - 3) // 2
        low[: 2 * bodies] = np.log(np.tile([LEAST_CAPACITY, LEAST_RESISTANCE], bodies))
        high[: 2 * bodies] = np.log(np.tile([CAPACITY.largest, THERMAL_RESISTANCE.largest], bodies))
        high[lag] = DURATION.largest
        return low[self.free], high[self.free]
