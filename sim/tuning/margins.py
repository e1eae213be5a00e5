"""How much a loop bears before it oscillates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.loop import minimal_pid, sampled
from heatwright.sim.tuning.process import Process

POINTS = 4000
"""Frequencies of the open loop, even in the logarithm; python-control interpolates between them."""

DECADES = 3
"""Below the slowest corner of the loop."""


@dataclass(frozen=True)
class Margins:
    """Robustness of a loop (Åström & Hägglund, Advanced PID Control, 2006, section 4.6)."""

    stable: bool
    """Whether all poles of the closed loop are inside the unit circle."""
    gain: float
    """By what the machine's gain may grow; infinite if by anything."""
    phase_deg: float
    """How much more phase it may lose at its crossover."""
    delay_s: float
    """How much more dead time that is, s."""
    sensitivity: float
    """Ms: the most by which the loop amplifies an error; its reciprocal is the distance to −1."""
    crossover: float
    """Frequency at which the open loop's gain is 1, rad/s; 0 if it never is."""


@dataclass(frozen=True)
class OpenLoop:
    """Frequency response of process and controller in series."""

    omega: NDArray[np.float64]
    """rad/s."""
    response: NDArray[np.complex128]


def open_loop(process: Process, gains: Gains, period_s: float) -> OpenLoop:
    """Compute the response of the sampled loop, up to half the sampling frequency."""
    slowest_s = max(process.lags_s[0], gains.kp / gains.ki if gains.ki else 0.0)
    omega = np.geomspace(10.0**-DECADES / slowest_s, math.pi / period_s, POINTS)
    z = np.exp(1j * omega * period_s)
    plant = _response(sampled(process, period_s), z)
    return OpenLoop(omega, plant * _response(minimal_pid(gains, period_s), z))


def _response(system: control.StateSpace, z: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray(np.squeeze(system(z), axis=(0, 1)) if np.ndim(system(z)) > 1 else system(z))


def margins(process: Process, gains: Gains, period_s: float) -> Margins:
    """Find the margins of a loop.

    Args:
        process: the machine.
        gains: of the PID.
        period_s: time between control steps, s.

    """
    loop = open_loop(process, gains, period_s)
    data = control.frd(loop.response, loop.omega, smooth=True)
    gain, phase, distance, _, crossings, _ = control.stability_margins(data, returnall=True)
    delays_s = np.radians(np.mod(phase, 360.0)) / crossings
    nearest = np.abs(1 + loop.response).min()
    smallest = float(min(distance.min(initial=np.inf), nearest))
    return Margins(
        stable=is_stable(process, gains, period_s),
        gain=_least_growth(gain),
        phase_deg=float(phase[np.abs(phase).argmin()]) if len(phase) else math.inf,
        delay_s=float(delays_s.min(initial=math.inf)),
        sensitivity=1 / smallest,
        crossover=float(crossings.max(initial=0.0)),
    )


def _least_growth(gains: NDArray[np.float64]) -> float:
    """Return the smallest growth that makes a stable loop oscillate; below 1 it does already."""
    growing = gains[gains > 1]
    if len(growing):
        return float(growing.min())
    return float(gains.max()) if len(gains) else math.inf


def is_stable(process: Process, gains: Gains, period_s: float) -> bool:
    """Tell whether the closed loop settles, where nothing is limited."""
    loop = control.series(minimal_pid(gains, period_s), sampled(process, period_s))
    closed = loop.A - loop.B @ loop.C / (1 + loop.D)
    return bool(np.abs(np.linalg.eigvals(closed)).max() < 1)
