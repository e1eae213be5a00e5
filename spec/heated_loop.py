"""One loop with its part of the plant, as healthy machines of its kind may be."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

from heatwright.spec.algorithms import Pid
from heatwright.spec.loops import MOST_STEPS
from heatwright.spec.matrices import Vector
from heatwright.spec.network import Heated
from heatwright.spec.outputs import DigitalOutput, Switch, TimeProportionalOutput
from heatwright.spec.simulation import AMBIENT, Simulation

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller

WINTER_C, SUMMER_C = 10.0, 35.0
"""A workshop in winter and in summer."""

SPARE = 0.1
"""Of the rise above the surroundings, which a node bears beyond what its protection lets happen."""

TIMES = 3.0
"""A machine may be so many times slower than its plant: capacities and resistances 30 % larger,
and less power beyond what it loses."""

SHORTEST_S = 20.0
SHORTEST_STEPS = 10
"""Of a time that is derived: a draught, or some readings that are lost, must not decide."""

OWN = 0.1
"""Of the range of setpoints: farther on a start goes the way of those that began there."""

HALVINGS = 40
MOST_POINTS = 400
"""Points of a course that is followed; its steps double after every 64."""

MOST_RISE = 3000
"""Points of a way from cold to the maximum; only absurd plants have more."""

PLACES = 4
"""Temperatures, and times without power, that are tried."""


class HeatedLoop:
    """One loop with its part of a plant, as the rules' numbers need it.

    Raises ArithmeticError, AssertionError, LookupError or ValueError for a plant that the checks
    refuse.
    """

    def __init__(self, controller: Controller, name: str, simulation: Simulation) -> None:
        loop, network = controller.loops[name], simulation.plant
        heater = controller.outputs[loop.heater]
        if not isinstance(heater, Switch) or heater.power_w is None or AMBIENT in network.nodes:
            raise ValueError(name)
        self.loop, self._network, self.ambient_c = loop, network, simulation.ambient_c
        self._heater, self.power_w = heater, heater.power_w
        self._always = _running(controller)
        sensor = controller.thermometers[loop.sensor]
        self.highest_c = loop.setpoint.maximum_c
        lowest_c = max(loop.setpoint.minimum_c, self.ambient_c)
        self.lowest_c = min(lowest_c, self.highest_c)
        ends = (self.lowest_c, self.highest_c)
        self.step_k = max(sensor.step_at_k(end_c, controller.board.mcu) for end_c in ends)
        self.plant = self.at(self.ambient_c)
        if not self.plant.steady_k(self.full_w) > self.highest_c - self.ambient_c:
            raise ValueError(name)

    def at(self, ambient_c: float) -> Heated:
        """Give the plant in other surroundings."""
        return Heated(self._network, self.loop.heater, self.loop.sensor, ambient_c, self._always)

    @property
    def full_w(self) -> float:
        """The most the algorithm asks for, as far as the current's limit lets it have it."""
        algorithm = self.loop.algorithm
        share = algorithm.output.maximum_percent / 100 if isinstance(algorithm, Pid) else 1.0
        return min(self.power_w * share, self._limit_w)

    @property
    def _limit_w(self) -> float:
        current = getattr(self._heater, "current", None)
        if current is None or current.limit_a is None:
            return math.inf
        return float(current.limit_a) * float(getattr(self._heater, "supply_v", None) or math.inf)

    @property
    def late_s(self) -> float:
        """How late heat that is asked for may be read: dead time, rests or windows, two steps."""
        output = self._heater
        rest_s = output.minimum_off_s if isinstance(output, DigitalOutput) else 0.0
        if isinstance(output, TimeProportionalOutput):
            rest_s = output.window_s
        return self.plant.delay_s + rest_s + 2 * self.loop.period_s

    @cached_property
    def hold_w(self) -> float:
        """Power that the highest setpoint takes."""
        return self.plant.power_w(self.highest_c - self.ambient_c)

    def most_hold_w(self) -> float:
        """Power that it takes in winter."""
        cold_c = min(WINTER_C, self.ambient_c)
        return self.at(cold_c).power_w(self.highest_c - cold_c)

    @cached_property
    def _warm(self) -> tuple[Heated, Vector]:
        """The plant on a warm day, and what each of its nodes bears above that.

        As `bears` says; else what full power makes of it from cold until the sensor reads
        `protection.maximum`, or a long time at that, and a tenth of the rise more.
        """
        warm_c = max(SUMMER_C, self.ambient_c)
        plant, size = self.at(warm_c), len(self._network.nodes)
        most_k = self.loop.protection.maximum_c - warm_c
        peaks, state = plant.held_k(most_k), plant.start(0.0)
        for power_w, points in ((self.full_w, MOST_RISE), (0.0, MOST_POINTS)):
            quick_s = plant.fastest_s() / 4
            course = plant.course(state, power_w, quick_s, 1024 * quick_s)
            for _, state in islice(course, points):
                peaks = [max(pair) for pair in zip(peaks, state[:size], strict=True)]
                if power_w and plant.sensed_k(state) >= most_k:
                    break
        given = [self._network.bears_c.get(node) for node in self._network.nodes]
        return plant, [
            (1 + SPARE) * peak_k if bears_c is None else bears_c - warm_c
            for peak_k, bears_c in zip(peaks, given, strict=True)
        ]

    def borne_w(self) -> float:
        """Power that every node bears for ever in summer; infinite if it bears all there is."""
        plant, bears_k = self._warm

        def borne(power_w: float) -> bool:
            return all(a <= b for a, b in zip(plant.nodes_k(power_w), bears_k, strict=True))

        if borne(self.full_w):
            return math.inf
        low_w, high_w = 0.0, self.full_w
        for _ in range(HALVINGS):
            middle_w = (low_w + high_w) / 2
            low_w, high_w = (middle_w, high_w) if borne(middle_w) else (low_w, middle_w)
        return low_w

    def borne_s(self, longest_s: float) -> float:
        """Time for which every node bears full power in summer, from rest at the highest setpoint.

        At most `longest_s`.
        """
        plant, bears_k = self._warm
        state = plant.rest(self.highest_c - max(SUMMER_C, self.ambient_c))
        quick_s = plant.fastest_s() / 4
        for time_s, later in plant.course(state, self.full_w, quick_s, longest_s / 64):
            if time_s >= longest_s or any(a > b for a, b in zip(later, bears_k, strict=False)):
                return min(time_s, longest_s)
        return longest_s

    def starts(self) -> Iterator[Vector]:
        """Yield states in which a healthy machine may be when heat is asked for anew.

        At rest at several temperatures; warming up at full power; and hot at the highest one, then
        without power for a while: the heater's element and the sensor have cooled, the rest less.
        """
        low_k, high_k = self.lowest_c - self.ambient_c, self.highest_c - self.ambient_c
        shares = [place / (PLACES - 1) for place in range(PLACES)]
        rests = [self.plant.rest(low_k + share * (high_k - low_k)) for share in shares]
        yield from rests
        yield from _some(self._warming(self.plant.rest(low_k), high_k))
        yield from _some(self._cooling(rests[-1], high_k))

    def _warming(self, state: Vector, high_k: float) -> Iterator[Vector]:
        for _, later in self.follow(state, self.full_w):
            if self.plant.sensed_k(later) >= high_k:
                return
            yield later

    def _cooling(self, state: Vector, high_k: float) -> Iterator[Vector]:
        for _, later in self.follow(state, 0.0):
            yield later
            if self.plant.sensed_k(later) < high_k / 4:
                return

    def follow(self, state: Vector, power_w: float) -> Iterator[tuple[float, Vector]]:
        """Yield times and states from one on at a power."""
        quick_s = self.plant.fastest_s() / 4
        return islice(self.plant.course(state, power_w, quick_s, 64 * quick_s), MOST_POINTS)

    def longest_still_s(self, power_w: float) -> float:
        """Return how long a reading may stand still at a power, below the highest setpoint, s.

        It moves once the temperature is a step from where it was.
        """
        return max(
            _longest_within(self._sensed(state, power_w), self.step_k) for state in self.starts()
        )

    def _sensed(self, state: Vector, power_w: float) -> Iterator[tuple[float, float]]:
        """Follow a start until all that it had of its own is over."""
        enough_k = (self.highest_c - self.lowest_c) * OWN + self.step_k
        most_k = min(
            self.plant.sensed_k(state) + enough_k, self.highest_c - self.ambient_c + self.step_k
        )
        for time_s, later in self.follow(state, power_w):
            sensed_k = self.plant.sensed_k(later)
            yield time_s, sensed_k
            if sensed_k >= most_k:
                return

    def rounded_s(self, seconds: float) -> float:
        """Round a time up to two digits; not too short to mean anything, nor too long to count."""
        period_s = self.loop.period_s
        least_s = max(seconds, SHORTEST_S, SHORTEST_STEPS * period_s)
        unit = 10.0 ** (math.floor(math.log10(least_s)) - 1)
        return min(math.ceil(least_s / unit - 1e-9) * unit, MOST_STEPS * period_s)


def _running(controller: Controller) -> list[str]:
    return [
        name
        for name, output in controller.outputs.items()
        if isinstance(output, DigitalOutput) and output.runs == "always"
    ]


def _some(states: Iterator[Vector]) -> list[Vector]:
    """Take a few, evenly."""
    found = list(states)
    return found[:: max(1, len(found) // PLACES)]


def _longest_within(course: Iterator[tuple[float, float]], band_k: float) -> float:
    """Return the longest time in which a course keeps within a band, wherever that lies.

    Between two points it is taken for straight.
    """
    points, first, longest_s = list(course), 0, 0.0
    low: deque[int] = deque()
    high: deque[int] = deque()
    for last, (time_s, value) in enumerate(points):
        while low and points[low[-1]][1] >= value:
            low.pop()
        while high and points[high[-1]][1] <= value:
            high.pop()
        low.append(last)
        high.append(last)
        while first < last and points[high[0]][1] - points[low[0]][1] >= band_k:
            first += 1
            for queue in (low, high):
                if queue[0] < first:
                    queue.popleft()
        left_k = band_k - (points[high[0]][1] - points[low[0]][1])
        beyond_s = [
            abs(points[there][0] - points[here][0])
            * min(1.0, left_k / max(abs(points[there][1] - points[here][1]), left_k))
            for here, there in ((first, first - 1), (last, last + 1))
            if 0 <= there < len(points)
        ]
        longest_s = max(longest_s, time_s - points[first][0] + max(beyond_s, default=0.0))
    return longest_s
