"""Reduce a process to the numbers that tuning rules need: gain, two lags, one dead time.

S. Skogestad, "Simple analytic rules for model reduction and PID controller tuning", Journal of
Process Control 13 (2003), section 2: the half rule, and rules T1 to T3 for zeros.
"""

from typing import NamedTuple

CLOSE = 1.6
"""A smaller lag within this factor of a lead is paired with it, in place of a larger lag."""

ROUNDS = 20
"""Iterations: the zero rules need the closed loop's time constant, which depends on them."""


class Reduced(NamedTuple):
    """gain·exp(−dead·s) / ((lag·s + 1)·(second·s + 1))."""

    gain: float
    """K/%."""
    lag_s: float
    second_s: float
    """0 in a first-order model."""
    dead_s: float


def reduce(  # noqa: PLR0913 - all have names
    *,
    gain: float,
    lags_s: list[float],
    leads_s: list[float],
    late_s: float,
    period_s: float,
    order: int,
) -> Reduced:
    """Reduce a process to first or second order.

    Sampling adds half a period of dead time (Skogestad, section 2.1).
    """
    dead_s = late_s + period_s / 2
    fast_s = dead_s
    reduced = _halved(gain, list(lags_s), dead_s, order)
    for _ in range(ROUNDS):
        factor, lags = _without_leads(list(lags_s), leads_s, fast_s)
        reduced = _halved(gain * factor, lags, dead_s, order)
        if reduced.dead_s == fast_s:
            break
        fast_s = reduced.dead_s
    return reduced


def _halved(gain: float, lags_s: list[float], dead_s: float, order: int) -> Reduced:
    """Apply the half rule: half of the largest neglected lag becomes lag, half dead time."""
    lags = sorted(lags_s, reverse=True)
    lags += [0.0] * (order + 1 - len(lags))
    kept, left_out = lags[:order], lags[order:]
    kept[-1] += left_out[0] / 2
    dead_s += left_out[0] / 2 + sum(left_out[1:])
    return Reduced(gain, kept[0], kept[1] if order > 1 else 0.0, dead_s)


def _without_leads(
    lags_s: list[float], leads_s: list[float], fast_s: float
) -> tuple[float, list[float]]:
    """Pair each lead with a lag; return what remains: a factor, and lags."""
    factor = 1.0
    for lead_s in sorted(leads_s, reverse=True):
        lag_s = _partner(lead_s, lags_s)
        lags_s.remove(lag_s)
        share, left = _pair(lead_s, lag_s, fast_s)
        factor *= share
        lags_s += left
    return factor, lags_s


def _partner(lead_s: float, lags_s: list[float]) -> float:
    """Choose the nearest larger lag; a smaller one if it is much nearer, or if none is larger."""
    larger = min((lag for lag in lags_s if lag >= lead_s), default=None)
    smaller = max((lag for lag in lags_s if lag < lead_s), default=None)
    if larger is None:
        return max(lags_s)
    near = smaller is not None and lead_s / smaller < CLOSE < larger / lead_s
    return smaller if near and smaller is not None else larger


def _pair(lead_s: float, lag_s: float, fast_s: float) -> tuple[float, list[float]]:
    """Approximate (lead·s + 1)/(lag·s + 1) for a loop of time constant `fast_s`."""
    if lead_s >= lag_s:  # T1, T1a, T1b
        return max(lead_s, fast_s) / max(lag_s, fast_s), []
    if lead_s >= 5 * fast_s:  # T2
        return lead_s / lag_s, []
    short_s = min(lag_s, 5 * fast_s)  # T3
    return short_s / lag_s, [short_s - lead_s]
