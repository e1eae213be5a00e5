"""The residuals between record and model: noise, pattern and outliers."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.stats import norm

from heatwright.sim.trace import Series

FALSE_ALARM = 0.05
"""Probability that a record of pure noise loses a reading (Bonferroni's share for each row)."""

NEIGHBOURS = 5
"""Number of rows of the median: two of them may be damaged."""

TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


def outliers(residuals_k: Series, resolution_k: float) -> NDArray[np.bool_]:
    """Find single readings that stand out: a damaged line, a sensor's power-on value.

    Each is compared with the median of its neighbours (Hampel's identifier: Davies & Gather,
    Journal of the American Statistical Association 88, 1993). If several in a row stand out, the
    model is wrong, not the readings.
    """
    beyond_k = np.abs(residuals_k - median_filter(residuals_k, NEIGHBOURS, mode="nearest"))
    spread_k = TO_SIGMA * float(np.median(np.abs(residuals_k - np.median(residuals_k))))
    # Rounding alone may put a good reading off by a step.
    limit_k = resolution_k + spread_k * float(norm.isf(FALSE_ALARM / 2 / len(residuals_k)))
    out = beyond_k > limit_k
    beside = np.zeros_like(out)
    beside[1:] |= out[:-1]
    beside[:-1] |= out[1:]
    return np.asarray(out & ~beside)


def noise(residuals_k: Series) -> float:
    """Return the standard deviation of the noise from one reading to the next, K.

    (von Neumann's mean square successive difference, Annals of Mathematical Statistics 12, 1941.)
    """
    return float(np.sqrt((np.diff(residuals_k) ** 2).mean() / 2))


def pattern(residuals_k: Series) -> float:
    """Return the part of the root mean square that noise does not explain, K."""
    return float(np.sqrt(max(0.0, (residuals_k**2).mean() - noise(residuals_k) ** 2)))


def correlation_rows(residuals_k: Series) -> float:
    """Return over how many rows r residuals are correlated: n rows count as n / r independent rows.

    1 + 2·Σρ_k, summed while pairs of neighbours stay positive (Geyer, Statistical Science 7, 1992).
    """
    count = len(residuals_k)
    centred = residuals_k - residuals_k.mean()
    size = 1 << (2 * count - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(centred, size)) ** 2
    covariance = np.fft.irfft(spectrum, size)[:count]
    if covariance[0] <= 0:
        return 1.0
    ratios = covariance / covariance[0]
    pairs = ratios[: count // 2 * 2].reshape(-1, 2).sum(axis=1)
    ended = np.flatnonzero(pairs <= 0)
    positive = pairs[: ended[0]] if len(ended) else pairs
    return max(1.0, float(2 * positive.sum() - 1))
