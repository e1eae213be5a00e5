"""The stability margins of a loop."""

import math
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.loop import minimal_pid, pid_response, sampled, sampled_response
from heatwright.sim.tuning.process import Process

POINTS = 1500
"""Number of frequencies, evenly spaced in the logarithm; python-control interpolates."""

DECADES = 3
"""Decades below the loop's lowest corner frequency."""

SOUND = 2.0
"""Largest Ms that gains may have (Åström & Hägglund, Advanced PID Control, 2006, section 4.6). It
leaves a gain margin of at least 2 and a phase margin of at least 29°."""


@dataclass(frozen=True)
class Margins:
    """Robustness of a loop (Åström & Hägglund, Advanced PID Control, 2006, section 4.6)."""

    stable: bool
    """Whether all poles of the closed loop are inside the unit circle."""
    gain: float
    """Factor by which the machine's gain may grow; infinite if there is no limit."""
    phase_deg: float
    """Further phase lag that the loop tolerates at its crossover."""
    delay_s: float
    """Further dead time that causes this phase lag, s."""
    sensitivity: float
    """Ms: the largest amplification of an error; its reciprocal is the distance to −1."""
    crossover: float
    """Frequency at which the open loop's gain is 1, rad/s; 0 if it never is."""

    @property
    def sound(self) -> bool:
        """Whether the loop is stable with an Ms of at most `SOUND`."""
        return self.stable and self.sensitivity <= SOUND


@dataclass(frozen=True)
class OpenLoop:
    """Frequency response of process and controller in series."""

    omega: NDArray[np.float64]
    """Frequencies, rad/s."""
    response: NDArray[np.complex128]


def open_loop(process: Process, gains: Gains, period_s: float) -> OpenLoop:
    """Compute the response of the sampled loop, up to half the sampling frequency."""
    slowest_s = max(process.lags_s[0], gains.kp / gains.ki if gains.ki else 0.0)
    omega = np.geomspace(10.0**-DECADES / slowest_s, math.pi / period_s, POINTS)
    z = np.exp(1j * omega * period_s)
    return OpenLoop(
        omega, sampled_response(process, period_s, z) * pid_response(gains, period_s, z)
    )


def margins(process: Process, gains: Gains, period_s: float) -> Margins:
    """Find the margins of a loop.

    process -- the machine; gains -- of the PID; period_s -- time between control steps, s.
    """
    loop = open_loop(process, gains, period_s)
    stable = is_stable(process, gains, period_s)
    data = control.frd(loop.response, loop.omega, smooth=True)
    gain, phase, distance, _, crossings, _ = control.stability_margins(data, returnall=True)
    delays_s = np.radians(np.mod(phase, 360.0)) / crossings
    nearest = np.abs(1 + loop.response).min()
    last = loop.response[-1].real  # at half the sampling frequency the response is real
    return Margins(
        stable=stable,
        gain=_growth(np.append(gain, -1 / last if last < 0 else math.inf), stable),
        phase_deg=float(phase[np.abs(phase).argmin()]) if len(phase) else math.inf,
        delay_s=float(delays_s.min(initial=math.inf)),
        sensitivity=1 / float(distance.min(initial=nearest)),
        crossover=float(crossings.max(initial=0.0)),
    )


def _growth(gains: NDArray[np.float64], stable: bool) -> float:
    """Return the gain factor to instability; of an unstable loop, the largest to stability."""
    if stable:
        return float(gains[gains > 1].min(initial=math.inf))
    return float(gains[gains < 1].max(initial=0.0))


def is_stable(process: Process, gains: Gains, period_s: float) -> bool:
    """Return whether the closed loop without limits is stable."""
    loop = control.series(minimal_pid(gains, period_s), sampled(process, period_s))
    closed = loop.A - loop.B @ loop.C / (1 + loop.D)
    return bool(np.abs(np.linalg.eigvals(closed)).max() < 1)
