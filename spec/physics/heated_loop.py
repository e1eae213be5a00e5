"""One loop with its part of the plant, within the tolerances of healthy machines."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

from heatwright.spec.loops import LONGEST_RULE_S, MOST_STEPS, Loop
from heatwright.spec.outputs import Switch, always_running, limit_w, waits_s
from heatwright.spec.physics.matrices import Vector
from heatwright.spec.physics.neighbours import Neighbour, warmed_k
from heatwright.spec.physics.network import Heated
from heatwright.spec.simulation import AMBIENT, Simulation

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller

WINTER_C, SUMMER_C = 5.0, 35.0
"""Temperature of a workshop in winter and in summer."""

SPARE = 0.1
"""Margin of a node's limit above what the protection allows, as a share of its rise."""

TIMES = 3.0
"""Factor on a time that the plant needs, because a real machine may be slower: its capacities and
resistances may be 30 % larger, and its losses may leave less of the power."""

LEAST_TIMES = 2.0
"""Factor used if nodes do not withstand `TIMES`: values some 30 % larger, a supply 10 % low."""

SHORTEST_STEPS = 10
"""Shortest derived time, in control steps: some lost readings must not cause a trip."""

OWN = 0.1
"""Share of the setpoints' range: a course that has risen by it no longer depends on its start."""

HALVINGS = 10
"""Bisections in the search for a time that all nodes withstand: exact to a thousandth."""

BORNE_HALVINGS = 40
"""Bisections after which the ends of the interval are practically equal."""
MOST_POINTS = 400
"""Maximum number of points of a course; its time steps double after every 64."""

MOST_RISE = 3000
"""Maximum number of points from cold to the maximum; only absurd plants need more."""

PLACES = 4
"""Number of start temperatures that are tried."""

CUTS = 5
"""Number of power cuts that are tried, each several times as long as the one before; the shortest
is a quarter of the plant's shortest time constant."""


_KNOWN: dict[str, HeatedLoop] = {}
"""Cache of loops by everything they depend on: the rows of a comparison are mostly equal."""

MOST_KNOWN = 16


def heated_loop(controller: Controller, name: str, simulation: Simulation) -> HeatedLoop:
    """Return a loop with its part of a plant; an earlier one if all it depends on is equal.

    Raises what HeatedLoop raises.
    """
    loop = controller.loops[name]
    heater = controller.switches.get(loop.heater)
    cooler = controller.outputs.get(loop.cooler) if loop.cooler else None
    full_w = _full_w(loop, heater) if heater else None
    others = [(each.heater, each.sensor, each.setpoint) for each in controller.loops.values()]
    setpoint, maximum_c = loop.setpoint, loop.protection.maximum_c
    running = always_running(controller.outputs)
    if len(others) == 1:
        others = []  # the initial setpoint of a loop alone changes nothing
    key = repr(
        (
            (simulation.plant, simulation.ambient_c, controller.board.mcu, running),
            (loop.sensor, controller.sensors, loop.period_s, maximum_c),
            (setpoint.minimum_c, setpoint.maximum_c, loop.heater, heater, full_w, cooler, others),
        )
    )
    if key not in _KNOWN:
        made = HeatedLoop(controller, name, simulation)
        if len(_KNOWN) >= MOST_KNOWN:
            _KNOWN.pop(next(iter(_KNOWN)))
        _KNOWN[key] = made
    return _KNOWN[key]


def most_borne(
    allowed: Callable[[float], bool], low: float, high: float, halvings: int = HALVINGS
) -> float:
    """Return by bisection the largest allowed value; `low` must be allowed, and `high` must not."""
    for _ in range(halvings):
        middle = (low + high) / 2
        low, high = (middle, high) if allowed(middle) else (low, middle)
    return low


class HeatedLoop:
    """One loop with its part of a plant, for the derivation of the rules' numbers.

    Raises ArithmeticError, AssertionError, LookupError, ValueError: the checks refuse the plant.
    """

    def __init__(self, controller: Controller, name: str, simulation: Simulation) -> None:
        loop, network = controller.loops[name], simulation.plant
        heater = controller.switches.get(loop.heater)
        if heater is None or heater.power_w is None or AMBIENT in network.nodes:
            raise ValueError(name)
        self._network, self.ambient_c = network, simulation.ambient_c
        self._parts, self.period_s = (loop.heater, loop.sensor), loop.period_s
        self._maximum_c = loop.protection.maximum_c
        self.nodes, self.given_c = tuple(network.nodes), network.bears_c
        self._heater, self.power_w = heater, heater.power_w
        self._always = always_running(controller.outputs)
        sensor = controller.thermometers[loop.sensor]
        self._behind_s = (sensor.moving_average - 1) / 2 * loop.period_s
        cooler = controller.outputs.get(loop.cooler) if loop.cooler else None
        self._cooled_s = cooler.stays_on_s if cooler else 0.0
        self._neighbours = [
            Neighbour(each.heater, each.sensor, each.setpoint.maximum_c - self.ambient_c)
            for other, each in controller.loops.items()
            if other != name
        ]
        self.highest_c = loop.setpoint.maximum_c
        lowest_c = max(loop.setpoint.minimum_c, self.ambient_c)
        self.lowest_c = min(lowest_c, self.highest_c)
        ends = (self.lowest_c, self.highest_c)
        self.step_k = max(sensor.step_at_k(end_c, controller.board.mcu) for end_c in ends)
        self.plant = self.at(self.ambient_c)
        self.full_w = _full_w(loop, heater)
        if not self.plant.steady_k(self.full_w) > self.highest_c - self.ambient_c:
            raise ValueError(name)

    def at(self, ambient_c: float) -> Heated:
        """Return the plant at another ambient temperature."""
        return Heated(self._network, *self._parts, ambient_c, self._always)

    @property
    def late_s(self) -> float:
        """Longest time from a duty to its effect on a reading: dead time, pause, two steps, s."""
        return self.plant.delay_s + self._rest_s + 2 * self.period_s

    @property
    def _rest_s(self) -> float:
        """Longest time for which the heater may have to stay off while the loop needs heat, s."""
        return max(waits_s(self._heater), self._cooled_s)

    @cached_property
    def hold_w(self) -> float:
        """Power that holds the highest setpoint, W."""
        return self.plant.power_w(self.highest_c - self.ambient_c)

    def most_hold_w(self) -> float:
        """Power that holds the highest setpoint in winter, W."""
        cold_c = min(WINTER_C, self.ambient_c)
        return self.at(cold_c).power_w(self.highest_c - cold_c)

    @cached_property
    def warm_rest(self) -> Vector:
        """The plant's steady state at the highest setpoint on a warm day."""
        return self.warm[0].rest(self.highest_c - max(SUMMER_C, self.ambient_c))

    @cached_property
    def warm(self) -> tuple[Heated, Vector]:
        """The plant on a warm day, and each node's limit above that day's ambient, K."""
        return self._bears_k(max(SUMMER_C, self.ambient_c))

    def _bears_k(self, ambient_c: float) -> tuple[Heated, Vector]:
        """Return the plant in some surroundings, and each node's limit above their temperature, K.

        A limit is the spec's `bears`; without it 1.1 times the rise at full power from cold until
        the rule of `protection.maximum` switches the heater off, or of the steady state there.
        """
        plant, size = self.at(ambient_c), len(self._network.nodes)
        most_k = self._maximum_c - ambient_c
        peaks, state = plant.held_k(most_k), plant.start(0.0)
        for power_w, points in ((self.full_w, MOST_RISE), (0.0, MOST_POINTS)):
            quick_s = plant.fastest_s() / 4
            course = plant.course(state, power_w, quick_s, 1024 * quick_s)
            for _, state in islice(course, points):
                peaks = [max(pair) for pair in zip(peaks, state[:size], strict=True)]
                if power_w and plant.sensed_k(state) >= most_k:
                    break
            state = plant.advance(state, power_w, 2 * self.period_s)  # until the heater is off
        given = [self.given_c.get(node) for node in self.nodes]
        return plant, [
            (1 + SPARE) * peak_k if bears_c is None else bears_c - ambient_c
            for peak_k, bears_c in zip(peaks, given, strict=True)
        ]

    @cached_property
    def borne_k(self) -> dict[str, float]:
        """Limits of the nodes' temperatures, above the spec's ambient, K.

        If other loops heat the machine, too, only this loop's own nodes and those with a given
        limit are in it. Each limit is the higher one of a warm day and a day at the spec's ambient.
        """
        warm_c = max(SUMMER_C, self.ambient_c)
        days = [(warm_c - self.ambient_c, self.warm[1])]
        if warm_c > self.ambient_c:
            days.append((0.0, self._bears_k(self.ambient_c)[1]))
        own = {self._network.heat[self._parts[0]], self._network.sense[self._parts[1]].node}
        return {
            node: max(above_k + bears_k[place] for above_k, bears_k in days)
            for place, node in enumerate(self.nodes)
            if node in own or node in self.given_c or not self._neighbours
        }

    def borne_w(self) -> float:
        """Power that all nodes withstand permanently in summer, W; infinite if it is full power."""
        plant, bears_k = self.warm

        def borne(power_w: float) -> bool:
            return all(a <= b for a, b in zip(plant.nodes_k(power_w), bears_k, strict=True))

        if borne(self.full_w):
            return math.inf
        return most_borne(borne, 0.0, self.full_w, BORNE_HALVINGS)

    @cached_property
    def _cold(self) -> list[tuple[float, Vector]]:
        """Times and states from cold at full power up to the highest setpoint."""
        return self._heating(self.plant.start(0.0), MOST_RISE)

    @cached_property
    def starts(self) -> Sequence[Vector]:
        """States in which a healthy machine may be when the loop begins to heat again.

        They are: the steady state at several temperatures; warming up at full power; and some time
        after the power failed at the highest temperature, when heater and sensor have cooled most.
        """
        low_k, high_k = self.lowest_c - self.ambient_c, self.highest_c - self.ambient_c
        shares = [place / (PLACES - 1) for place in range(PLACES)]
        rests = [self.plant.rest(low_k + share * (high_k - low_k)) for share in shares]
        cooling = list(self._cooling(rests[-1], high_k))
        cold = [state for _, state in self._cold if self.plant.sensed_k(state) >= low_k]
        return [
            *rests,
            *cold[:: max(1, len(cold) // PLACES)],
            *(cooling[4**place] for place in range(CUTS) if 4**place < len(cooling)),
        ]

    def _cooling(self, state: Vector, high_k: float) -> Iterator[Vector]:
        for _, later in self.follow(state, 0.0):
            yield later
            if self.plant.sensed_k(later) < high_k / 4:
                return

    def follow(self, state: Vector, power_w: float) -> Iterator[tuple[float, Vector]]:
        """Yield times and states from a state on, at a constant power."""
        quick_s = self.plant.fastest_s() / 4
        return islice(self.plant.course(state, power_w, quick_s, 64 * quick_s), MOST_POINTS)

    def longest_still_s(self, power_w: float) -> float:
        """Return how long a reading may be constant at a power, below the highest setpoint, s.

        The reading changes once the temperature has changed by a step.
        """
        return max(
            _longest_within(self._sensed(state, power_w), self.step_k) for state in self.starts
        )

    def _sensed(self, state: Vector, power_w: float) -> Iterator[tuple[float, float]]:
        """Yield times and temperatures from a start on, until the course is independent of it."""
        enough_k = (self.highest_c - self.lowest_c) * OWN + self.step_k
        most_k = min(
            self.plant.sensed_k(state) + enough_k, self.highest_c - self.ambient_c + self.step_k
        )
        for time_s, later in self.follow(state, power_w):
            sensed_k = self.plant.sensed_k(later)
            yield time_s, sensed_k
            if sensed_k >= most_k:
                return

    def slowest_rise(self, rise_k: float, short_k: float = 0.0) -> tuple[float, float]:
        """Return the longest time that full power takes for a rise, s, and where it began, °C.

        It begins cold and in all `starts`, and ends `short_k` below the highest setpoint. A reading
        may be a step too low. If the heater has to wait first, the machine cools meanwhile; the
        wait itself is not counted.
        """
        risen_k = rise_k + self.step_k
        return max(
            (longest_to_rise(self._short(course, short_k), risen_k) - wait_s, from_c)
            for wait_s, from_c, course in self._courses
        )

    @cached_property
    def _courses(self) -> list[tuple[float, float, list[tuple[float, float]]]]:
        """Waits, s, first temperatures, °C, and courses at full power, from all starts and cold."""
        rest_s, plant = self._rest_s, self.plant
        waits = [(0.0, state) for state in self.starts]
        waits += [(rest_s, state) for state in self.starts] if rest_s else []
        found = []
        for wait_s, state in waits:
            heated = self._heating(
                plant.advance(state, 0.0, wait_s) if wait_s else state, MOST_POINTS
            )
            course = [(wait_s + time_s, plant.sensed_k(later)) for time_s, later in heated]
            first = [(0.0, plant.sensed_k(state))] if wait_s else []
            found.append((wait_s, self.ambient_c + plant.sensed_k(state), [*first, *course]))
        cold = [(time_s, plant.sensed_k(state)) for time_s, state in self._cold]
        return [*found, (0.0, self.ambient_c + cold[0][1], cold)]

    def _short(
        self, course: list[tuple[float, float]], short_k: float
    ) -> list[tuple[float, float]]:
        """Cut a course off after its first point within `short_k` of the highest setpoint."""
        most_k = self.highest_c - self.ambient_c - short_k
        above = (place for place, (_, sensed_k) in enumerate(course) if sensed_k >= most_k)
        return course[: next(above, len(course)) + 1]

    def _heating(self, state: Vector, points: int) -> list[tuple[float, Vector]]:
        """Follow a start state at full power up to the highest setpoint."""
        quick_s, most_k = self.plant.fastest_s() / 4, self.highest_c - self.ambient_c
        found: list[tuple[float, Vector]] = []
        course = self.plant.course(state, self.full_w, quick_s, 64 * quick_s)
        for time_s, later in islice(course, points):
            found.append((time_s, later))
            if self.plant.sensed_k(later) >= most_k:
                break
        return found

    @cached_property
    def _coasting(self) -> list[tuple[float, float]]:
        """Times and temperatures above the highest setpoint after full power up to there.

        The heater goes off late: the reading is old, and the heater may have to stay on.
        """
        most_k, (_, state) = self.highest_c - self.ambient_c, self._cold[-1]
        late_s = self.plant.delay_s + self._behind_s + self.period_s + self._heater.stays_on_s
        state = self.plant.advance(state, self.full_w, late_s)
        coasting: list[tuple[float, float]] = []
        for time_s, later in self.follow(state, 0.0):
            over_k = self.plant.sensed_k(later) - most_k
            if coasting and over_k < coasting[-1][1]:
                break
            coasting.append((late_s + time_s, over_k))
        return coasting

    def way_k(self, node: str, ambient_c: float, spread: float) -> float:
        """Rise of a node above ambient at full power, until the highest setpoint is read, K.

        spread -- share by which resistances may be larger: a hotter node is then hotter still.
        """
        plant, place = self.at(ambient_c), self.nodes.index(node)
        most_k = self.highest_c - ambient_c
        quick_s, peak_k = plant.fastest_s() / 4, 0.0
        course = plant.course(plant.start(0.0), self.full_w, quick_s, 64 * quick_s)
        for _, state in islice(course, MOST_RISE):
            if plant.sensed_k(state) >= most_k:
                break
            peak_k = max(peak_k, state[place])
        return peak_k + spread * max(0.0, peak_k - most_k)

    @property
    def overshoot_k(self) -> float:
        """Overshoot of the sensor above the highest setpoint after full power, K."""
        return self._coasting[-1][1]

    def settles_s(self, enough_k: float) -> float:
        """Return the time after which the reading coasts up by no more than `enough_k`, s."""
        return next(
            time_s for time_s, over_k in self._coasting if self.overshoot_k - over_k < enough_k
        )

    @cached_property
    def warmed_k(self) -> float:
        """Rise of the sensor above ambient by the other loops' heaters, K."""
        return warmed_k(
            self._network, self._parts[1], self._neighbours, self.ambient_c, self._always
        )

    def rounded_s(self, seconds: float, shortest_s: float) -> float:
        """Round a time up to two digits: at least the shortest, at most a day, and countable."""
        return self._rounded_s(seconds, shortest_s, math.ceil)

    def rounded_down_s(self, seconds: float, shortest_s: float) -> float:
        """Round a time down to two digits, within the same limits."""
        return self._rounded_s(seconds, shortest_s, math.floor)

    def _rounded_s(self, seconds: float, shortest_s: float, whole: Callable[[float], int]) -> float:
        period_s = self.period_s
        least_s = max(seconds, shortest_s, SHORTEST_STEPS * period_s)
        unit = 10.0 ** (math.floor(math.log10(least_s)) - 1)
        rounded_s = whole(least_s / unit + (1e-9 if whole is math.floor else -1e-9)) * unit
        most_s = min(MOST_STEPS * period_s, LONGEST_RULE_S)
        return min(max(rounded_s, SHORTEST_STEPS * period_s), most_s)


def longest_to_rise(course: Sequence[tuple[float, float]], rise_k: float) -> float:
    """Return the longest time that a course takes for a rise, from any of its points on.

    A rise that is not finished is counted up to the course's end. Points are joined by lines.
    """
    longest_s, last = 0.0, 0
    for first, (from_s, from_k) in enumerate(course):
        last = max(last, first)
        while last < len(course) and course[last][1] < from_k + rise_k:
            last += 1
        if last == len(course):
            return max(longest_s, course[-1][0] - from_s)
        (before_s, before_k), (after_s, after_k) = course[last - 1], course[last]
        share = (from_k + rise_k - before_k) / (after_k - before_k)
        longest_s = max(longest_s, before_s + share * (after_s - before_s) - from_s)
    return longest_s


def _full_w(loop: Loop, heater: Switch) -> float:
    """Return the highest power of the algorithm, or of the current limit if that is lower, W."""
    return min((heater.power_w or 0.0) * loop.algorithm.full_percent / 100, limit_w(heater))


def _longest_within(course: Iterator[tuple[float, float]], band_k: float) -> float:
    """Return the longest time in which a course keeps within a band, wherever that lies.

    Between two points a course is linear.
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
