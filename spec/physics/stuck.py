"""What a loop makes of its machine while its reading tells nothing: it heats on, up to full power.

A reading that stands still a little below the setpoint raises the duty as the integral grows; one
that falls to the surroundings asks for full power at once. Only rules that count such heat end it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

from heatwright.spec.algorithms import Algorithm
from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop
from heatwright.spec.physics.matrices import Vector, apply
from heatwright.spec.physics.network import Heated

BELOW_K = 5.0
"""So far below its setpoint a reading stands still: `verify` tries the same. Nearer to it the duty
grows more slowly, and is the longer above what holding needs."""

PIECES = 48
"""Number of pieces into which the time until a rule trips, or the integral's rise, is divided."""

LEAST_PERCENT = 0.01
"""A duty is above `holding` from so much on."""

MOST_POINTS = 400
SPREADING_S = 600.0
"""How long heat that is under way is followed: `verify` does so, too."""

LONGEST_S = 4 * 3600.0
"""Machines are at rest by then, or `verify` watches them no longer."""


class Times(NamedTuple):
    """Times of the rules that count heat, s; infinite without such a rule."""

    within_s: float
    for_s: float
    holding_percent: float


class Lie(NamedTuple):
    """How a loop asks for heat while its reading is wrong.

    first_percent, per_s -- the duty from the beginning, and its growth; up to most_percent.
    """

    first_percent: float
    per_s: float
    most_percent: float

    def reaches_s(self, percent: float) -> float:
        """Return when the duty is as high, s; never: infinite."""
        if self.first_percent >= percent:
            return 0.0
        if self.per_s <= 0 or self.most_percent < percent:
            return math.inf
        return (percent - self.first_percent) / self.per_s

    def percent(self, time_s: float) -> float:
        """Return the duty at a time."""
        return min(self.most_percent, self.first_percent + self.per_s * time_s)


def still(algorithm: Algorithm, integral_percent: float, below_k: float = BELOW_K) -> Lie:
    """Return what a loop asks for while its reading stands still a little below the setpoint."""
    full = algorithm.full_percent
    pid = algorithm.pid
    if pid is None or below_k > pid.on_at_k:
        return Lie(full, 0.0, full)
    if pid.keeps_output and below_k <= pid.dead_band_k:
        return Lie(full, 0.0, full)  # as it was when the band was entered: anything
    error_k = below_k if below_k > pid.dead_band_k else 0.0
    proportional, most = pid.kp * error_k, pid.integral.maximum_percent
    if not pid.ki:
        integral_percent = most = 0.0
    first = min(full, proportional + integral_percent)
    return Lie(first, pid.ki * error_k, max(first, min(full, proportional + most)))


def fallen(algorithm: Algorithm) -> Lie:
    """Return the same while the reading is that of the surroundings: it falls far at once."""
    full = algorithm.full_percent
    return Lie(full, 0.0, full)


def ends_s(loop: Loop, lie: Lie, times: Times) -> float:
    """Return when the first rule ends it, s: a period to see it, and one more until it is off."""
    full = loop.algorithm.full_percent
    if loop.algorithm.limits_adjustable and lie.first_percent < full:
        full = math.inf  # a host may have left the integral too little to get there
    counts_s = (
        lie.reaches_s(full) + times.within_s,
        lie.reaches_s(times.holding_percent + LEAST_PERCENT) + times.for_s,
    )
    return min(counts_s) + loop.periods_s(2)


def peaks_k(heated: HeatedLoop, plant: Heated, start: Vector, lie: Lie, time_s: float) -> Vector:
    """Return how hot each node becomes if this goes on for a time, and then the heat spreads, K."""
    step_s, state = min(time_s, LONGEST_S) / PIECES, start
    size = len(start) - 1 - bool(plant.lag_s)
    peaks, about = start[:size], start
    without, added = plant.pushed(step_s, about)
    for piece in range(PIECES):
        if plant.bent(about, state):
            about = state
            without, added = plant.pushed(step_s, about)
        power_w = min(heated.power_w * lie.percent((piece + 0.5) * step_s) / 100, heated.full_w)
        carried = apply(without, state)
        state = [old + power_w * each for old, each in zip(carried, added, strict=True)]
        peaks = [max(pair) for pair in zip(peaks, state[:size], strict=True)]
    for later in _spreading(plant, state):
        peaks = [max(pair) for pair in zip(peaks, later[:size], strict=True)]
    return peaks


def _spreading(plant: Heated, state: Vector) -> Iterator[Vector]:
    """Yield states without power until no node becomes hotter."""
    quick_s, size = plant.fastest_s() / 4, len(state) - 1 - bool(plant.lag_s)
    before = state
    for time_s, later in islice(plant.course(state, 0.0, quick_s, 64 * quick_s), MOST_POINTS):
        if time_s and (time_s > SPREADING_S or not any(map(float.__gt__, later[:size], before))):
            return
        yield later
        before = later
