"""Fit the plant that is nearest to a record; the uncertainty of its parameters."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from heatwright.sim.identify.log import Unusable
from heatwright.sim.identify.record import Record
from heatwright.sim.identify.residuals import correlation_rows, noise, outliers
from heatwright.sim.identify.search import Beginning, Setting, beginnings
from heatwright.sim.identify.solution import Solution, ordered, solve
from heatwright.sim.identify.structure import Structure
from heatwright.sim.identify.verdict import Found, findings, warnings
from heatwright.sim.trace import Series

Progress = Callable[[float, float], None]
"""Called with the number of fits that are done, and their total number."""

ROUGH_ROWS = 2000
"""Readings used while start values are compared; the best one is then fitted to all."""


@dataclass(frozen=True)
class Identified:
    """The plant that was found, and how well it fits."""

    record: Record
    structure: Structure
    values: Series
    """Parameters in the order of the structure's."""
    found: tuple[Found, ...]
    """The parameters with their uncertainty."""
    model_c: Series
    """The readings of the plant that was found, at the rows of the record."""
    left_out: NDArray[np.bool_]
    """Rows whose readings no machine could give; they were left out of the fit."""
    at_rest: bool
    """Whether the fit assumes that the machine was in its steady state when the record began."""
    warnings: tuple[str, ...]

    @property
    def residuals_k(self) -> Series:
        """Reading minus model at the fitted rows, K."""
        kept = ~self.left_out
        return np.asarray(self.record.readings_c[kept] - self.model_c[kept])

    @property
    def rms_k(self) -> float:
        """Root mean square of the residuals, K."""
        return float(np.sqrt((self.residuals_k**2).mean()))

    @property
    def worst_k(self) -> float:
        """Largest distance between reading and model, K."""
        return float(np.abs(self.residuals_k).max())

    @property
    def noise_k(self) -> float:
        """Noise from one reading to the next, without pattern, K."""
        return noise(self.residuals_k)

    @property
    def percent(self) -> float:
        """Share of the readings' movement that the model explains; 100 %: all."""
        readings_c = self.record.readings_c[~self.left_out]
        return float(100 * (1 - self.rms_k / readings_c.std()))


def fit(  # noqa: PLR0913 - all but two have defaults and names
    record: Record,
    structure: Structure,
    *,
    ambient_c: float | None = None,
    age_s: float = 0.0,
    cold: bool = False,
    progress: Progress | None = None,
) -> Identified:
    """Fit a machine to a record.

    record -- times, readings, power; structure -- the structure of the plant to find; ambient_c --
    ambient temperature if known, °C; otherwise it is fitted, too; age_s -- how old a reading is
    when it is logged, s; cold -- whether the machine was at ambient when the record began;
    otherwise this is judged; progress -- called with the progress of the fits. Raises Unusable: no
    machine with a heater that heats comes near the record.
    """
    best = _best(Setting(record, structure, age_s, ambient_c), cold, progress)
    wrong = outliers(best.residuals_k, record.resolution_k)
    if wrong.any():
        setting = replace(best.setting, record=record.without(wrong))
        best = solve(setting, best.beginning)
    return _identified(best, record, wrong)


def _best(setting: Setting, cold: bool, progress: Progress | None) -> Solution:
    """Return the best fit of all start values; a steady start is chosen if it fits as well."""
    starts = list(_starts(setting, cold))
    if not starts:
        raise Unusable(
            "gets no warmer from its heater: no machine fits. Are duty and temperature the right "
            "columns (--columns)?"
        )
    rough: list[Solution] = []
    for number, (each, start) in enumerate(starts, 1):
        rough.append(solve(each, start, most_rows=ROUGH_ROWS, exact=False))
        if progress is not None:
            progress(number, len(starts) + 1)
    chosen = min(rough, key=lambda each: each.cost)
    rested = min((each for each in rough if each.setting.rest), key=lambda each: each.cost)
    if _as_good(rested, chosen):
        chosen = rested
    return ordered(solve(chosen.setting, chosen.beginning))


def _starts(setting: Setting, cold: bool) -> Iterator[tuple[Setting, Beginning]]:
    """Yield the start values of the fits.

    The heater may have been switched on by the first row, or long before it; the machine may have
    been in the steady state then, or not.
    """
    first_w = float(setting.record.powers_w[0])
    moves = bool(setting.record.steps)
    for before_w in (0.0,) if cold else sorted({0.0, first_w}):
        for rest in (True,) if cold else (True, False):
            if before_w > 0 and rest and not moves:
                continue  # in the steady state of a constant power no temperature would ever change
            each = replace(setting, before_w=before_w, rest=rest)
            for start in beginnings(each):
                yield each, start


def _as_good(rested: Solution, free: Solution) -> bool:
    """Return whether a start in the steady state fits as well as free temperatures at the start.

    By the Bayesian information criterion (Schwarz, Annals of Statistics 6, 1978), with the
    equivalent number of independent residuals.
    """
    worth = len(free.residuals_k) / correlation_rows(free.residuals_k)
    if free.cost == 0:
        return rested.cost == 0
    states = free.setting.structure.states
    return worth * math.log(rested.cost / free.cost) < states * math.log(max(2.0, worth))


def _identified(best: Solution, record: Record, wrong: NDArray[np.bool_]) -> Identified:
    structure = best.setting.structure
    half = half_widths(best)
    given = best.setting.ambient_c is not None
    told = findings(structure, best.values, half, record, ambient_given=given)
    return Identified(
        record=record,
        structure=structure,
        values=best.values,
        found=told,
        model_c=best.model_c(),
        left_out=wrong,
        at_rest=best.setting.rest,
        warnings=(*warnings(told, best.residuals_k, record, structure), *_left_out(wrong)),
    )


def _left_out(wrong: NDArray[np.bool_]) -> tuple[str, ...]:
    if not wrong.any():
        return ()
    return (
        "single readings far from their neighbours are left out of the fit as damaged: "
        f"{int(wrong.sum())}",
    )


CONFIDENCE = 0.95


def half_widths(solution: Solution) -> Series:
    """Return half of each parameter's 95 % interval, in the units of the fit; 0 if it was given.

    Linearised about the solution (Seber & Wild, Nonlinear Regression, 1989, chapter 5). Correlated
    residuals contain less information: the covariance is that of independent residuals, multiplied
    by the number of rows over which they are correlated.
    """
    residuals_k = solution.residuals_k
    count, unknowns = solution.jacobian.shape
    rows = correlation_rows(residuals_k)
    freedom = max(1.0, count / rows - unknowns)
    variance_k2 = float((residuals_k**2).sum()) / max(1, count - unknowns) * rows
    spread = np.sqrt(variance_k2 * _inverse_diagonal(solution.jacobian))
    half = np.zeros(len(solution.free))
    looked_for = int(solution.free.sum())
    half[solution.free] = float(student.ppf((1 + CONFIDENCE) / 2, freedom)) * spread[:looked_for]
    return half


def _inverse_diagonal(jacobian: NDArray[np.float64]) -> Series:
    """Return the diagonal of (JᵀJ)⁻¹; infinite for parameters without effect on the record."""
    scale = np.linalg.norm(jacobian, axis=0)
    seen = scale > 0
    _, singular, right = np.linalg.svd(jacobian[:, seen] / scale[seen], full_matrices=False)
    blind = singular < np.finfo(float).eps * len(jacobian) * singular[0]
    shares = (right / np.where(blind, 1.0, singular)[:, None]) ** 2
    touched = (np.abs(right[blind]) > np.sqrt(np.finfo(float).eps)).any(axis=0)
    found = np.full(jacobian.shape[1], np.inf)
    found[seen] = np.where(touched, np.inf, shares[~blind].sum(axis=0) / scale[seen] ** 2)
    return found
