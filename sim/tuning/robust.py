"""Gains for many machines: drawn around the spec's, simulated together, optimised for all.

A real machine differs from the spec: capacities and resistances are estimates, the room is warmer
or colder, and the supply is not exactly its nominal voltage. All machines are heated from cold with
all gains in question, one in each lane of `heatwright.sim.arrays`.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.arrays.world import step_logs
from heatwright.sim.bench import Progress
from heatwright.sim.judges.metrics import overshoot, response_of, settling
from heatwright.sim.plants import supplied
from heatwright.sim.trace import StepLog
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.margins import SOUND, open_loop
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.trial import at_setpoint, ending, heat, with_gains
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

BETTER = 0.999
"""A new cost must be below this share of the old one; otherwise the search keeps the old gains."""
GENERATIONS = 12
FIRST, LAST = 1.0, 1 / 8
"""First and smallest size of the search's steps, in octaves of a gain or time."""
_KEPT = ("temperature_c", "setpoint_c", "has_reading", "enabled", "fault.code")


class Spread(NamedTuple):
    """How far machines differ from the spec's; each quantity is uniformly distributed."""

    share: float = 0.2
    """Spread of capacities and resistances, as a share."""
    ambient_k: float = 5.0
    supply: float = 0.05
    """Spread of the supply voltage, as a share; the power is proportional to its square."""


class Machine(NamedTuple):
    """One drawn machine."""

    controller: Controller
    process: Process
    """The process near the target."""
    warm_s: float
    """Time from cold to the target at full power, s."""


class Outcome(NamedTuple):
    """The result of heating a machine from cold and holding it."""

    overshoot_k: float
    settling_s: float | None
    tripped: bool
    cost: float
    """Error times the time since the start, integrated (ITAE: D. Graham, R. C. Lathrop, Trans. AIEE
    72, 1953), relative to the step and to the square of the time at full power. An error up to one
    step of the sensor counts as none. Infinite if a rule tripped."""


def drawn(controller: Controller, spread: Spread, count: int, seed: int) -> Iterator[Controller]:
    """Draw controllers with machines; each is drawn from the seed and its number alone."""
    simulation = controller.simulated
    plant = simulation.plant
    for number in range(count):
        random = np.random.default_rng((seed, number))
        nodes = {name: own * _about(random, spread.share) for name, own in plant.nodes.items()}
        links = tuple(
            link.model_copy(update={
                "resistance_k_per_w": link.resistance_k_per_w * _about(random, spread.share)
            })
            for link in plant.links
        )  # fmt: skip
        ambient_c = simulation.ambient_c + spread.ambient_k * (_about(random, 1.0) - 1)
        changed = simulation.model_copy(update={
            "plant": plant.model_copy(update={"nodes": ReadOnlyDict(nodes), "links": links}),
            "ambient_c": ambient_c,
        })  # fmt: skip
        yield supplied(controller, _about(random, spread.supply)).model_copy(
            update={"simulation": changed}
        )


def _about(random: np.random.Generator, share: float) -> float:
    return float(random.uniform(1 - share, 1 + share))


class Course(NamedTuple):
    """The test of each machine."""

    controller: Controller
    """The spec, from which the firmware is generated."""
    loop: str
    target_c: float
    length_s: float
    step_k: float
    """One step of the sensor."""

    def tried(
        self, gains: Sequence[Gains], machines: Sequence[Machine], progress: Progress | None = None
    ) -> list[list[Outcome]]:
        """Heat all machines with all gains; return the outcomes of each of the gains."""
        found: list[list[Outcome]] = [[] for _ in gains]
        for terms in dict.fromkeys(map(_terms, gains)):  # lanes must have the same terms
            places = [place for place, each in enumerate(gains) if _terms(each) == terms]
            own = [self._with(gains[place]) for place in places for _ in machines]
            logs = iter(step_logs(
                own,
                (*heat(own[0], self.loop, self.target_c), ending(self.length_s)),
                _KEPT,
                machines=[each.controller for _ in places for each in machines],
                progress=progress,
            ))  # fmt: skip
            for place in places:
                found[place] = [self._outcome(next(logs)[self.loop], each) for each in machines]
        return found

    def _with(self, gains: Gains) -> Controller:
        tuned = with_gains(self.controller, self.loop, gains)
        return at_setpoint(tuned, self.loop, self.target_c)

    def _outcome(self, log: StepLog, machine: Machine) -> Outcome:
        response = response_of(log)
        response = response[response["has_reading"] != 0]
        tripped = bool(log["fault.code"].any())
        if not len(response):
            return Outcome(0.0, None, tripped, math.inf)
        times_s = response["time_s"] - response["time_s"][0]
        readings_c = response["temperature_c"].astype(float)
        errors_k = np.maximum(np.abs(readings_c - self.target_c) - self.step_k, 0.0)
        whole = max(self.step_k, abs(self.target_c - readings_c[0])) * machine.warm_s**2
        lost_k = float((times_s * errors_k).sum())
        cost = self.controller.loops[self.loop].integral(lost_k) / whole
        return Outcome(
            overshoot(readings_c, self.target_c),
            settling(times_s, readings_c, self.target_c, self.step_k),
            tripped,
            math.inf if tripped else cost,
        )


def _terms(gains: Gains) -> tuple[bool, ...]:
    return gains.ki > 0, gains.kd > 0


def worst_cost(outcomes: Iterable[Outcome]) -> float:
    """Return the cost of gains, which is their cost on the worst machine."""
    return max(each.cost for each in outcomes)


def is_sound(gains: Gains, machines: Iterable[Machine], period_s: float) -> bool:
    """Return whether the open loop stays as far from −1 as `SOUND` demands on every machine."""
    return all(
        np.abs(1 + open_loop(each.process, gains, period_s).response).min() >= 1 / SOUND
        for each in machines
    )


def improved(
    start: Gains, cost: float, costs_of: Callable[[Sequence[Gains]], Sequence[float]]
) -> Gains:
    """Improve gains until no step of an eighth of an octave helps: a compass search.

    T. G. Kolda, R. M. Lewis, V. Torczon, "Optimization by direct search", SIAM Review 45 (2003). It
    varies gain, integral time and derivative time by their logarithms; a value of 0 stays 0. Steps
    of two sizes are tried together.

    start -- the first gains; cost -- of the start; costs_of -- returns the costs of some gains.
    """
    axes = np.eye(3)[[True, start.ki > 0, start.kd > 0]]
    here, size = np.zeros(3), FIRST
    for _ in range(GENERATIONS):
        if size < LAST:
            break
        places = [here + way * axis for way in (size, -size, size / 2, -size / 2) for axis in axes]
        costs = costs_of([_at(start, place) for place in places])
        best = int(np.argmin(costs))
        if costs[best] >= BETTER * cost:
            size /= 4
            continue
        here, cost = places[best], costs[best]
        if best >= len(places) // 2:
            size /= 2
    return _at(start, here)


def _at(start: Gains, octaves: NDArray[np.float64]) -> Gains:
    """Return gains changed by some octaves of gain, integral time and derivative time."""
    gain, integral, derivative = (2.0**octaves).tolist()
    return Gains(
        start.kp * gain, start.ki * gain / integral, start.kd * gain * derivative, start.filter_s
    )
