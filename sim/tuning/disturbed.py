"""The response of a loop to a load, and the effect of its sensor's steps on the duty."""

from dataclasses import dataclass

import numpy as np

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.loop import minimal_pid, sampled
from heatwright.sim.tuning.process import Process

LOAD_PERCENT = 10.0
"""Share of the power that a load suddenly takes away."""

LONGEST = 20_000
"""Maximum number of control steps that are computed."""


@dataclass(frozen=True)
class Load:
    """Response to a load of 10 % of the power."""

    dip_k: float
    """Largest error."""
    after_s: float
    """Time of the largest error, s."""
    half_s: float | None
    """Time after which the error stays below half of `dip_k`, s; None: not in the time computed."""


def load_answer(process: Process, gains: Gains, period_s: float) -> Load:
    """Compute the linear loop's response to a load step, until long after it has settled.

    The loop must be stable.
    """
    plant, controller = sampled(process, period_s), minimal_pid(gains, period_s)
    states, ours = np.zeros(plant.nstates), np.zeros(controller.nstates)
    step, given, seen = (np.asarray(each) for each in (plant.A, plant.B[:, 0], plant.C[0]))
    own_step, own_given, own_out = controller.A, controller.B[:, 0], controller.C[0]
    direct = float(controller.D[0, 0])
    slow_s = max(process.lags_s[0], gains.kp / gains.ki if gains.ki else 0.0)
    count = min(LONGEST, int(5 * slow_s / period_s) + 1)
    errors = np.zeros(count)
    for number in range(count):
        error = -float(seen @ states)
        errors[number] = error
        duty = float(own_out @ ours) + direct * error - LOAD_PERCENT
        ours = own_step @ ours + own_given * error
        states = step @ states + given * duty
    worst = int(np.abs(errors).argmax())
    dip_k = float(abs(errors[worst]))
    outside = np.flatnonzero(np.abs(errors) > dip_k / 2)
    last = int(outside[-1]) if len(outside) else 0
    half_s = (last + 1) * period_s if last + 1 < count else None
    return Load(dip_k, worst * period_s, half_s)


def step_kick(gains: Gains, step_k: float, period_s: float) -> float:
    """Return how much one step of the sensor changes the duty at once, %."""
    slope = gains.kd / (gains.filter_s + period_s) if gains.kd else 0.0
    return (gains.kp + gains.ki * period_s + slope) * step_k
