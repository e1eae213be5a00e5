"""A machine in the steady state whose sensor then reads wrong: how hot its nodes become.

Two faults are tried: the reading is stuck a little below the setpoint, or the sensor has fallen out
and reads the surroundings. The heater stays on until a rule trips that limits this time. Somebody
may acknowledge each trip of a sensor that has fallen out, and command heat.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop
from heatwright.spec.physics.matrices import Vector
from heatwright.spec.physics.stuck import (
    BELOW_K,
    Lie,
    Spell,
    Times,
    ends_s,
    fall,
    fallen,
    insisted,
    peaks_k,
    still,
)


class _Case(NamedTuple):
    """A sensor that reads wrong.

    counts_from_s -- when the time of `frozen` begins: once the reading is constant.
    else_s -- when a rule trips that does not depend on the time of heating.
    off_s -- how long rule `rise_rate` lets nobody acknowledge.
    """

    words: str
    lie: Lie
    counts_from_s: float = 0.0
    else_s: float = math.inf
    off_s: float = 0.0


class Peak(NamedTuple):
    """A node that becomes too hot, its highest temperature, and its limit."""

    node: str
    peak_c: float
    bears_c: float
    words: str


class Stand:
    """A loop in the steady state between ambient and a setpoint, whose sensor then reads wrong."""

    def __init__(self, loop: Loop, heated: HeatedLoop, setpoint_c: float) -> None:
        self.loop, self.heated = loop, heated
        self._below_k = max(0.0, min(BELOW_K, setpoint_c - heated.ambient_c))
        self._fallen_k = max(0.0, setpoint_c - self._below_k - heated.ambient_c)
        self._start = heated.plant.rest(self._fallen_k)
        self._borne_k = heated.borne_k
        self._out = self._fallen_out()
        self._cases = []
        if self._below_k > 0:
            lie = still(loop.algorithm, 0.0, self._below_k)
            self._cases.append(_Case("whose reading is stuck", lie))
        if self._out is not None and self._out.else_s > 0:
            self._cases.append(self._out)

    def _fallen_out(self) -> _Case | None:
        loop, heated, else_s = self.loop, self.heated, math.inf
        protection, step_k = loop.protection, heated.step_k
        if heated.ambient_c <= protection.minimum_c or self._fallen_k <= step_k:
            return None
        falls = fall(loop, heated.plant.lag_s, self._fallen_k, step_k)
        if protection.runaway is not None and (protection.runaway.below_k or 0.0) >= self._below_k:
            else_s = falls.still_s + protection.runaway.for_s
        if falls.fastest_k > loop.rise_per_period_k:
            else_s = 0.0  # rule `rise_rate` trips at once
        lie = fallen(loop.algorithm)
        return _Case("that has fallen out", lie, falls.still_s, else_s, falls.slow_s)

    def again_s(self, times: Times) -> float:
        """Return how long after an acknowledgement the next trip may come; 0 if never, s."""
        if self._out is None:
            return 0.0
        return ends_s(self.loop, self._out.lie, times) + self.loop.periods_s(1)

    def insisted(self, times: Times, again: int) -> Peak | None:
        """Return the node furthest above its limit if somebody acknowledges `again` times."""
        found = self._too_hot(self._out, times, 0.0, again) if self._out and again else ()
        return max(found, key=_above_k, default=None)

    def worst(self, times: Times, share: float = 0.0) -> Peak | None:
        """Return the node furthest above its limit; None if all stay within `share` of theirs."""
        peaks = [peak for case in self._cases for peak in self._too_hot(case, times, share)]
        return max(peaks, key=_above_k, default=None)

    def peak_c(self, node: str, times: Times) -> float:
        """Return how hot a node becomes in the worst case, °C."""
        place = self.heated.nodes.index(node)
        peaks = (self._peaks_k(case, times)[place] for case in self._cases)
        return self.heated.ambient_c + max(peaks)

    def _peaks_k(self, case: _Case, times: Times, again: int = 0) -> Vector:
        later = times._replace(for_s=times.for_s + case.counts_from_s)
        time_s = min(ends_s(self.loop, case.lie, later), case.else_s)
        first = Spell(case.lie, time_s, case.off_s - time_s)
        spells = insisted(self.loop, times, first, again)
        return peaks_k(self.heated, self.heated.plant, self._start, spells)

    def _too_hot(self, case: _Case, times: Times, share: float, again: int = 0) -> Iterator[Peak]:
        heated = self.heated
        for node, peak_k in zip(heated.nodes, self._peaks_k(case, times, again), strict=True):
            most_k = self._borne_k.get(node, math.inf)
            if peak_k > most_k * (1 + share):
                ambient_c = heated.ambient_c
                yield Peak(node, ambient_c + peak_k, ambient_c + most_k, case.words)


def _above_k(peak: Peak) -> float:
    return peak.peak_c - peak.bears_c


def times_of(loop: Loop) -> Times:
    """Return the times of a loop's rules `heating` and `frozen`."""
    heating, frozen = loop.protection.heating, loop.protection.frozen
    return Times(
        math.inf if heating is None else heating.within_s,
        math.inf if frozen is None else frozen.for_s,
        100.0 if frozen is None else frozen.holding_percent,
    )
