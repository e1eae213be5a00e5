"""The sampled loop: the process with constant duty between steps, and the firmware's PID.

K. J. Åström, B. Wittenmark, Computer-Controlled Systems, 3rd ed. 1997: section 3.2 for a process
with dead time, sampled; chapter 8 for backward differences.
"""

import math

import control
import numpy as np
from numpy.typing import NDArray

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.process import Matrix, Process


def sampled(process: Process, period_s: float) -> control.StateSpace:
    """Sample a process whose duty is constant over a period; exact, dead time included."""
    whole, transition, fresh, old = _held(process, period_s)
    size = len(process.rates)
    states = size + whole + 1
    step, given = np.zeros((states, states)), np.zeros((states, 1))
    step[:size, :size] = transition
    # The delayed duties come after the process's own states, the oldest last.
    step[:size, -1] = old
    if whole:
        step[:size, -2] = fresh
        step[np.arange(size + 1, states), np.arange(size, states - 1)] = 1.0
    else:
        given[:size, 0] = fresh
    given[size, 0] = 1.0
    seen = np.concatenate((process.reading, np.zeros(whole + 1)))[None, :]
    return control.ss(step, given, seen, 0.0, period_s)


def sampled_response(
    process: Process, period_s: float, z: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Compute the frequency response of the sampled process, without states for delayed duties."""
    whole, transition, fresh, old = _held(process, period_s)
    given = fresh * z[:, None] ** -whole + old * z[:, None] ** -(whole + 1)
    free = z[:, None, None] * np.eye(len(transition)) - transition
    return np.asarray(np.linalg.solve(free, given[:, :, None])[:, :, 0] @ process.reading)


def _held(process: Process, period_s: float) -> tuple[int, Matrix, Matrix, Matrix]:
    """Sample a process: x ← F·x + fresh·u of `whole` periods ago + old·u of one more."""
    whole = math.floor(process.late_s / period_s)
    rest_s = process.late_s - whole * period_s
    transition, _ = process.held(period_s)
    after, fresh = process.held(period_s - rest_s)
    _, old = process.held(rest_s)
    return whole, transition, fresh, after @ old


def pid(gains: Gains, period_s: float) -> control.StateSpace:
    """Return the firmware's PID from error to duty (docs/control.md), without limits."""
    share = period_s / (gains.filter_s + period_s)
    slope = gains.kd * share / period_s
    ki_step = gains.ki * period_s
    step: Matrix = np.diag([1.0, 1.0 - share])
    given = np.array([[1.0], [-share]])
    out = np.array([[ki_step, slope]])
    return control.ss(step, given, out, gains.kp + ki_step + slope, period_s)


def minimal_pid(gains: Gains, period_s: float) -> control.StateSpace:
    """Return the PID without the states of terms that are off: an unused integrator is no pole."""
    whole = pid(gains, period_s)
    kept = [state for state, on in enumerate((gains.ki, gains.kd)) if on]
    return control.ss(
        whole.A[np.ix_(kept, kept)], whole.B[kept], whole.C[:, kept], whole.D, period_s
    )


def pid_response(
    gains: Gains, period_s: float, z: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Compute the frequency response of the PID."""
    share = period_s / (gains.filter_s + period_s)
    integral = gains.ki * period_s * z / (z - 1)
    slope = gains.kd * share / period_s * (z - 1) / (z - 1 + share)
    return np.asarray(gains.kp + integral + slope)
