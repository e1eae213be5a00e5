"""The uncertainty of the parameters of a fit."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from heatwright.sim.identify.residuals import correlation_rows
from heatwright.sim.identify.solution import Solution
from heatwright.sim.trace import Series

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
