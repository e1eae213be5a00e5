"""How a loop heats its machine while its reading is wrong: without end, up to full power.

If a reading is stuck a little below the setpoint, the duty grows with the integral; if it falls to
ambient, the duty is full at once. Only rules that limit the time of heating end this. Somebody may
acknowledge the trip and command heat again, until the lock-out needs a person at the machine.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

from heatwright.spec.algorithms import Algorithm, Lie
from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop
from heatwright.spec.physics.matrices import Vector, apply
from heatwright.spec.physics.network import Heated

BELOW_K = 5.0
"""How far below its setpoint a reading is stuck, K, as in `verify`. Nearer to it the duty grows
more slowly, and takes longer from the duty that holding needs to full power."""

PIECES = 48
"""Number of pieces into which the time until a rule trips, or the integral's rise, is divided."""

LEAST_PERCENT = 0.01
"""Least difference by which a duty is above `holding`, %."""

MOST_POINTS = 400
SPREADING_S = 600.0
"""How long a machine is simulated after the heater went off, s, as in `verify`."""

LONGEST_S = 4 * 3600.0
"""Longest simulated time, s: by then the machine is steady, or its run in `verify` has ended."""


class Times(NamedTuple):
    """Times of rules `heating` and `frozen`, s, infinite without the rule; and its `holding`."""

    within_s: float
    for_s: float
    holding_percent: float


OFF = Lie(0.0, 0.0, 0.0)
"""No power."""


def fallen(algorithm: Algorithm) -> Lie:
    """Return the duty of a loop whose reading has fallen to ambient: full power."""
    full = algorithm.full_percent
    return Lie(full, 0.0, full)


def ends_s(loop: Loop, lie: Lie, times: Times) -> float:
    """Return when the first rule has switched the heater off, s: two periods after its time."""
    full = loop.algorithm.full_percent
    if loop.algorithm.limits_adjustable and lie.first_percent < full:
        full = math.inf  # with a host's limits the duty may never be full
    counts_s = (
        lie.reaches_s(full) + times.within_s,
        lie.reaches_s(times.holding_percent + LEAST_PERCENT) + times.for_s,
    )
    return min(counts_s) + loop.periods_s(2)


class Spell(NamedTuple):
    """Power that a wrong reading causes for `lasts_s`, and no power for `off_s` after it."""

    lie: Lie
    lasts_s: float
    off_s: float = 0.0


class Fall(NamedTuple):
    """How the reading of a sensor that has fallen out falls to ambient.

    slow_s -- when it falls so slowly that `rise_rate` lets somebody acknowledge, as in `verify`;
    still_s -- when it is constant.
    """

    slow_s: float
    still_s: float


def fall(loop: Loop, lag_s: float, above_k: float, step_k: float) -> Fall:
    """Return how a reading falls from `above_k` above ambient in steps of `step_k`."""
    if not lag_s:
        return Fall(0.0, 0.0)
    share = _fall_share(loop, lag_s)
    slow_s = lag_s * math.log(max(1.0, 2 * above_k * share / loop.rise_per_period_k))
    return Fall(slow_s, lag_s * math.log(max(1.0, above_k / step_k)))


def slow_fall_k(loop: Loop, lag_s: float, step_k: float) -> float:
    """Return how far above ambient a sensor may fall out without a certain trip of `rise_rate`.

    Two readings may share the fastest fall, and each may be wrong by a step.
    """
    if not lag_s:
        return 0.0
    share = _fall_share(loop, lag_s)
    return (loop.rise_per_period_k + step_k) * (1 + share) / share


def _fall_share(loop: Loop, lag_s: float) -> float:
    """Return the share of its distance to ambient by which a reading falls in a period."""
    return 1 - math.exp(-loop.periods_s(1) / lag_s)


def insisted(
    loop: Loop, times: Times, first: Spell, still_s: float, waits_s: Sequence[float]
) -> list[Spell]:
    """Return the first spell, and one for each of `waits_s`, after which somebody acknowledges.

    The later spells are at full power. A fall that lasts until `still_s` delays rule `frozen`.
    """
    lie, period_s = fallen(loop.algorithm), loop.periods_s(1)
    spells, now_s = [first], first.lasts_s
    for wait_s in waits_s:
        off_s = max(period_s, wait_s, spells[-1].off_s)
        now_s += off_s
        later = times._replace(for_s=times.for_s + max(0.0, still_s - now_s))
        spells[-1] = spells[-1]._replace(off_s=off_s)
        spells.append(Spell(lie, ends_s(loop, lie, later)))
        now_s += spells[-1].lasts_s
    return spells


def peaks_k(heated: HeatedLoop, plant: Heated, start: Vector, spells: Sequence[Spell]) -> Vector:
    """Return each node's peak above ambient, with spells of power whose heat then spreads.

    spells -- from the second on, none is longer, or has a shorter rest, than the one before it.
    """
    size = len(start) - 1 - bool(plant.lag_s)
    peaks, state, rested, before = start[:size], start, start, None
    for spell in spells:
        if before is not None:
            begun = rested
            *_, rested = _given(heated, plant, state, OFF, before.off_s)
            cooler = all(new <= old for new, old in zip(rested, begun, strict=True))
            no_more = spell.lasts_s <= before.lasts_s and spell.off_s >= before.off_s
            if cooler and no_more and spell.lie == before.lie:
                break  # each spell begins cooler than the one before
        for state in _given(heated, plant, rested, spell.lie, spell.lasts_s):
            peaks = [max(pair) for pair in zip(peaks, state[:size], strict=True)]
        before = spell
    for later in _spreading(plant, state):
        peaks = [max(pair) for pair in zip(peaks, later[:size], strict=True)]
    return peaks


def _given(
    heated: HeatedLoop, plant: Heated, state: Vector, lie: Lie, lasts_s: float
) -> Iterator[Vector]:
    """Yield the states while the heater has the duty of a wrong reading."""
    step_s, about = min(lasts_s, LONGEST_S) / PIECES, plant.snapped(state)
    without, added = plant.pushed(step_s, about)
    for piece in range(PIECES):
        if plant.bent(about, state):
            about = plant.snapped(state)
            without, added = plant.pushed(step_s, about)
        power_w = min(heated.power_w * lie.percent((piece + 0.5) * step_s) / 100, heated.full_w)
        carried = apply(without, state)
        later = [old + power_w * each for old, each in zip(carried, added, strict=True)]
        bent = plant.bent(about, later)
        state = plant.advance(state, power_w, step_s) if bent else later
        yield state


def _spreading(plant: Heated, state: Vector) -> Iterator[Vector]:
    """Yield states without power until no node becomes hotter."""
    quick_s, size = plant.fastest_s() / 4, len(state) - 1 - bool(plant.lag_s)
    before = state
    for time_s, later in islice(plant.course(state, 0.0, quick_s, 64 * quick_s), MOST_POINTS):
        if time_s and (time_s > SPREADING_S or not any(map(float.__gt__, later[:size], before))):
            return
        yield later
        before = later
