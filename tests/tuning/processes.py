"""Processes of one lag, of which all is known in closed form."""

import numpy as np

from heatwright.sim.tuning.process import Process


def first_order(gain: float, lag_s: float, late_s: float = 0.0) -> Process:
    """gain·exp(−late·s)/(lag·s + 1)."""
    return Process(np.array([[-1 / lag_s]]), np.array([gain / lag_s]), np.array([1.0]), late_s)


def second_order(gain: float, lag_s: float, second_s: float, late_s: float = 0.0) -> Process:
    """gain·exp(−late·s)/((lag·s + 1)(second·s + 1))."""
    return Process(
        np.array([[-1 / lag_s, 0.0], [1 / second_s, -1 / second_s]]),
        np.array([gain / lag_s, 0.0]),
        np.array([0.0, 1.0]),
        late_s,
    )
