"""How hot a machine's nodes become while its sensor reads wrong, compared with their limits.

Two faults are tried: the reading is stuck a little below the setpoint, or the sensor has fallen out
and reads the surroundings. The heater stays on until a rule trips that limits this time.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.commands import commanded
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop, most_borne
from heatwright.spec.physics.matrices import Vector
from heatwright.spec.physics.stuck import BELOW_K, Lie, Times, ends_s, fallen, peaks_k, still
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, duration

SHARE = 0.02
"""Largest error of these peaks compared with `verify`, as a share of the rise above ambient."""


class _Case(NamedTuple):
    """A sensor that reads wrong.

    counts_from_s -- when the time of `frozen` begins: once the reading is constant.
    else_s -- when a rule trips that does not depend on the time of heating.
    """

    words: str
    lie: Lie
    counts_from_s: float = 0.0
    else_s: float = math.inf


class _Peak(NamedTuple):
    """A node that becomes too hot, its highest temperature, and its limit."""

    node: str
    peak_c: float
    bears_c: float
    words: str


def nodes_bear_the_maximum(machine: Machine, heated: HeatedLoop) -> Findings:
    """Find nodes whose limit is below the temperature that they can keep without a trip."""
    maximum_c = machine.loop.protection.maximum_c
    most_k = min(maximum_c - heated.ambient_c, heated.plant.steady_k(heated.full_w))
    for node, above_k in zip(heated.nodes, heated.plant.held_k(most_k), strict=True):
        bears_c, rests_c = heated.given_c.get(node), heated.ambient_c + above_k
        if bears_c is not None and bears_c < rests_c * (1 - 1e-9):
            yield Finding(
                ("simulation", "plant", "bears", node),
                f"with the sensor at {celsius(heated.ambient_c + most_k)}, which "
                f"{'.'.join(map(str, machine.path))}.protection.maximum allows without a trip, "
                f"{node} is at {about(rests_c)} °C",
                f"Use at least {about(math.ceil(10 * rests_c) / 10)} °C, or a lower maximum",
                (*machine.because_of, (*machine.path, "protection", "maximum")),
            )


def lying_sensors_are_borne(
    controller: Controller, machine: Machine, heated: HeatedLoop
) -> Findings:
    """Find rules that trip too late for a node when the sensor reads wrong."""
    loop = machine.loop
    if loop.protection.maximum_c <= heated.highest_c:
        return  # another check reports it; the nodes' limits follow from a valid maximum
    name = str(machine.path[1])
    top_c = heated.highest_c if commanded(controller, name) else loop.setpoint.initial_c
    stand = _Stand(loop, heated, min(top_c, heated.highest_c))
    found = stand.worst(_times(loop), SHARE)
    if found is None:
        return
    yield Finding(*_told(machine, stand, found), machine.because_of)


class _Stand:
    """A loop in the steady state between ambient and a setpoint, whose sensor then reads wrong."""

    def __init__(self, loop: Loop, heated: HeatedLoop, setpoint_c: float) -> None:
        self.loop, self.heated = loop, heated
        self._below_k = max(0.0, min(BELOW_K, setpoint_c - heated.ambient_c))
        self._fallen_k = max(0.0, setpoint_c - self._below_k - heated.ambient_c)
        self._start = heated.plant.rest(self._fallen_k)
        self._borne_k = heated.borne_k()
        self._cases = list(self._lies())

    def _lies(self) -> Iterator[_Case]:
        algorithm = self.loop.algorithm
        if self._below_k > 0:
            yield _Case("whose reading is stuck", still(algorithm, 0.0, self._below_k))
        loop, lag_s = self.loop, self.heated.plant.lag_s
        fastest_k = self._fallen_k * (1 - math.exp(-loop.period_s / lag_s)) if lag_s else math.inf
        protection = loop.protection
        if (
            fastest_k > loop.rise_per_period_k
            or self.heated.ambient_c <= protection.minimum_c
            or self._fallen_k <= self.heated.step_k
        ):
            return
        falls_s = lag_s * math.log(self._fallen_k / self.heated.step_k)
        else_s = math.inf
        if protection.runaway is not None and (protection.runaway.below_k or 0.0) >= self._below_k:
            else_s = falls_s + protection.runaway.for_s
        yield _Case("that has fallen out", fallen(algorithm), falls_s, else_s)

    def worst(self, times: Times, share: float = 0.0) -> _Peak | None:
        """Return the node furthest above its limit; None if all stay within `share` of theirs."""
        peaks = [peak for case in self._cases for peak in self._too_hot(case, times, share)]
        return max(peaks, key=lambda peak: peak.peak_c - peak.bears_c, default=None)

    def peak_c(self, node: str, times: Times) -> float:
        """Return how hot a node becomes in the worst case, °C."""
        place = self.heated.nodes.index(node)
        peaks = (self._peaks_k(case, times)[place] for case in self._cases)
        return self.heated.ambient_c + max(peaks)

    def _peaks_k(self, case: _Case, times: Times) -> Vector:
        later = times._replace(for_s=times.for_s + case.counts_from_s)
        time_s = min(ends_s(self.loop, case.lie, later), case.else_s)
        return peaks_k(self.heated, self.heated.plant, self._start, case.lie, time_s)

    def _too_hot(self, case: _Case, times: Times, share: float) -> Iterator[_Peak]:
        heated = self.heated
        for node, peak_k in zip(heated.nodes, self._peaks_k(case, times), strict=True):
            most_k = self._borne_k.get(node, math.inf)
            if peak_k > most_k * (1 + share):
                ambient_c = heated.ambient_c
                yield _Peak(node, ambient_c + peak_k, ambient_c + most_k, case.words)


def _told(machine: Machine, stand: _Stand, found: _Peak) -> tuple[Path, str, str]:
    """Return the key to change, the reason, and the remedy with a number that is enough."""
    path = (*machine.path, "protection")
    reason = (
        f"with a sensor {found.words}, {found.node} reaches {about(found.peak_c)} °C before a rule "
        f"trips, and it withstands {about(found.bears_c)} °C"
    )
    bears = f"simulation.plant.bears: {{{found.node}: {math.ceil(found.peak_c)} °C}}"
    for key, times, would_do_s in _numbers(machine.loop, stand):
        left = stand.peak_c(found.node, times)
        return (
            (*path, *key),
            reason,
            f"Use at most {duration(would_do_s)}, with which it reaches {about(left)} °C; or, if "
            f"it withstands more, write {bears}",
        )
    return (
        path,
        f"{reason}; no rule can trip sooner without tripping on the healthy machine, too",
        f"Use a heater of less power, or, if it withstands that, write {bears}",
    )


def _numbers(loop: Loop, stand: _Stand) -> Iterator[tuple[tuple[str, str], Times, float]]:
    """Yield each rule's longest time that protects all nodes and never trips a healthy machine."""
    now, heated = _times(loop), stand.heated
    heating, frozen = loop.protection.heating, loop.protection.frozen
    if heating is not None:
        needs_s = heated.slowest_rise(heating.rise_k)[0] + heated.late_s
        yield from _longest(
            stand, ("heating", "within"), needs_s, now.within_s,
            lambda each_s: now._replace(within_s=each_s),
        )  # fmt: skip
    if frozen is not None:
        power_w = min(heated.power_w * frozen.holding_percent / 100, heated.full_w)
        if power_w > heated.hold_w:
            needs_s = heated.longest_still_s(power_w) + heated.late_s
            yield from _longest(
                stand, ("frozen", "for"), needs_s, now.for_s,
                lambda each_s: now._replace(for_s=each_s),
            )  # fmt: skip


def _longest(
    stand: _Stand,
    key: tuple[str, str],
    needs_s: float,
    now_s: float,
    times: Callable[[float], Times],
) -> Iterator[tuple[tuple[str, str], Times, float]]:
    if needs_s >= now_s or stand.worst(times(needs_s)) is not None:
        return
    low_s = most_borne(lambda each_s: stand.worst(times(each_s)) is None, needs_s, now_s)
    unit = 10.0 ** (math.floor(math.log10(low_s)) - 2)
    rounded_s = math.floor(low_s / unit) * unit
    if rounded_s > needs_s:
        yield key, times(rounded_s), float(f"{rounded_s:.3g}")


def _times(loop: Loop) -> Times:
    heating, frozen = loop.protection.heating, loop.protection.frozen
    return Times(
        math.inf if heating is None else heating.within_s,
        math.inf if frozen is None else frozen.for_s,
        100.0 if frozen is None else frozen.holding_percent,
    )
