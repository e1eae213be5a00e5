"""A machine in the steady state whose sensor then reads wrong: how hot its nodes become.

Two faults are tried: the reading is stuck a little below the setpoint, or the sensor has fallen out
and reads the surroundings. The heater stays on until a rule trips that limits this time. Somebody
may acknowledge each trip of a sensor that has fallen out, and command heat.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from heatwright.spec.algorithms import Lie
from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop
from heatwright.spec.physics.matrices import Vector
from heatwright.spec.physics.stuck import (
    BELOW_K,
    Fall,
    Spell,
    Times,
    ends_s,
    fall,
    fallen,
    insisted,
    peaks_k,
    slow_fall_k,
)

MANY = 20
"""How many trips are tried if the lock-out counts none of them."""

LONGEST_WITHIN_S = 12 * 3600.0
"""Longest time for which the language lets the lock-out count trips, s."""


class _Case(NamedTuple):
    """A sensor that reads wrong.

    start -- the machine's state; falls -- how the reading falls to ambient, which delays `frozen`;
    else_s -- when a rule trips that does not depend on the time of heating.
    """

    words: str
    start: Vector
    lie: Lie
    falls: Fall = Fall(0.0, 0.0)
    else_s: float = math.inf


class Peak(NamedTuple):
    """A node that becomes too hot, its highest temperature, and its limit."""

    node: str
    peak_c: float
    bears_c: float
    words: str


class Stand:
    """A loop in the steady state between ambient and a setpoint, whose sensor then reads wrong."""

    def __init__(self, loop: Loop, heated: HeatedLoop, setpoints_c: tuple[float, float]) -> None:
        """Take the lowest and the highest setpoint that somebody may set, °C."""
        self.loop, self.heated = loop, heated
        low_k, high_k = (min(each, heated.highest_c) - heated.ambient_c for each in setpoints_c)
        below_k = max(0.0, min(BELOW_K, high_k))
        self._fallen = list(self._fallen_out(low_k - BELOW_K, max(0.0, high_k - below_k), below_k))
        self._cases = [each for each in self._fallen if each.else_s > 0]
        if below_k > 0:
            start, lie = heated.plant.rest(high_k - below_k), loop.algorithm.stuck(below_k, 0.0)
            self._cases.insert(0, _Case("whose reading is stuck", start, lie))

    def _fallen_out(self, low_k: float, high_k: float, below_k: float) -> Iterator[_Case]:
        """Yield cases from the highest setpoint, and from the highest without a trip at once."""
        loop, heated = self.loop, self.heated
        protection, plant, step_k = loop.protection, heated.plant, heated.step_k
        if heated.ambient_c <= protection.minimum_c or high_k <= step_k:
            return
        slow_k = slow_fall_k(loop, plant.lag_s, step_k)
        starts_k = [high_k] if not max(low_k, step_k) < slow_k < high_k else [high_k, slow_k]
        for above_k in starts_k:
            falls, else_s = fall(loop, plant.lag_s, above_k, step_k), math.inf
            runaway = protection.runaway
            if runaway is not None and (runaway.below_k or 0.0) >= below_k:
                else_s = falls.still_s + runaway.for_s
            if above_k > slow_k:
                else_s = 0.0  # rule `rise_rate` trips at once
            lie = fallen(loop.algorithm)
            yield _Case("that has fallen out", plant.rest(above_k), lie, falls, else_s)

    def insisted(self, times: Times, trips: int) -> Peak | None:
        """Return the node furthest above its limit if all trips but the last are acknowledged."""
        return self._hottest(times, [0.0] * (trips - 1))

    def trips_borne(self, times: Times, most: int) -> int:
        """Return how many trips all nodes withstand, at most `most`; 1 needs no acknowledgement."""
        return next((n for n in range(most, 1, -1) if self.insisted(times, n) is None), 1)

    def uncounted(self, times: Times, within_s: float) -> Peak | None:
        """Return the node that is too hot if somebody waits until a trip no longer counts."""
        lasts_s = ends_s(self.loop, fallen(self.loop.algorithm), times)
        return self._hottest(times, [within_s - lasts_s] * MANY)

    def _hottest(self, times: Times, waits_s: Sequence[float]) -> Peak | None:
        found = (peak for case in self._fallen for peak in self._too_hot(case, times, 0.0, waits_s))
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

    def _peaks_k(self, case: _Case, times: Times, waits_s: Sequence[float] = ()) -> Vector:
        later = times._replace(for_s=times.for_s + case.falls.still_s)
        time_s = min(ends_s(self.loop, case.lie, later), case.else_s)
        first = Spell(case.lie, time_s, case.falls.slow_s - time_s)
        spells = insisted(self.loop, times, first, case.falls.still_s, waits_s)
        return peaks_k(self.heated, self.heated.plant, case.start, spells)

    def _too_hot(
        self, case: _Case, times: Times, share: float, waits_s: Sequence[float] = ()
    ) -> Iterator[Peak]:
        heated = self.heated
        for node, peak_k in zip(heated.nodes, self._peaks_k(case, times, waits_s), strict=True):
            most_k = heated.borne_k.get(node, math.inf)
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


def counted_for_s(stand: Stand, times: Times, within_s: float) -> float | None:
    """Return a time for which the lock-out must count trips, s: `within_s` times a power of 2.

    None if even the longest time that the language allows is too short.
    """
    while within_s <= LONGEST_WITHIN_S:
        if stand.uncounted(times, within_s) is None:
            return within_s
        within_s *= 2
    return None
