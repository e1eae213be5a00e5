"""How much power a healthy machine needs for its reading: the basis of rules 33 and 34.

The plant gives the power that holds a reading. A healthy machine needs more or less: resistances
differ by the plant's tolerance, supply and room temperature vary, fans run, material is fed. The
heater's power, filtered as the plant filters it, must stay between the extremes of these cases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from heatwright.spec.loops import Effort, EffortBand, EffortLine
from heatwright.spec.outputs import always_running
from heatwright.spec.physics.feeds import fed_plant
from heatwright.spec.physics.heated_loop import SUMMER_C, WINTER_C, HeatedLoop
from heatwright.spec.physics.matrices import Vector, apply
from heatwright.spec.physics.network import Heated
from heatwright.spec.quantity import about, number
from heatwright.spec.simulation import Simulation, ThermalNetwork

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller
    from heatwright.spec.loops import Loop

SUPPLY = (0.85, 1.1)
"""Mains may be 15 % low or 10 % high (EN 50160); the power changes with its square."""

SPARE = 0.05
"""Margin of a limit, as a share: a machine at the corner of its tolerances swings around it."""

SUN_K = 5.0
"""How far an unheated machine may read above a room in summer, K, by sun and a sensor's error."""

LEAST_MOVE_K, LEAST_MOVE_STEPS, SIGMAS = 2.0, 3.0, 8.0
"""Changes of the reading below these, in K, steps of the sensor and standard deviations of its
noise, are ignored: a steady reading may change as much."""

TIMES, FILTERS, SHORTEST_S = 1.5, 0.5, 60.0
"""For a rule's time: a factor on the longest healthy time, which assumes ideal control; a factor
on the filter's time, for worse control; and the shortest time, s."""

SWINGS = 1.5
"""Swing of the temperature as a multiple of the algorithm's `swing_k`, because heat comes late."""

WINDOW_SHARE = 0.1
"""Longest window of a loop that switches, as a share of the filter's time. The output applies a new
duty only once in a window: in a longer one the power differs much from the duty."""

STANDS = 0.99
"""Share of `move_k` by which a reading may change and is certainly still ignored."""

LEAST_SHARE = 4e-6
"""Smallest coefficient of a filter in single precision: a smaller one is lost in rounding."""

BEND_PERCENT = 1.0
MOST_LINES = 8
"""Maximum number of straight lines that approximate a curve of radiation."""

POINTS, SLOW_TIMES, SETPOINTS = 120, 8.0, 8
"""Points of a simulated course, its length in times of the slowest part, and setpoints tried."""


TURNS = 12
"""Number of iterations of the searches here, such as that for the slowest part."""


def effort_of(
    controller: Controller,
    name: str,
    simulation: Simulation,
    heated: HeatedLoop,
    given: Effort | None,
) -> Effort | None:
    """Derive the numbers that a spec leaves open; None if no time suits a healthy machine.

    given -- the spec's rule; None if it is left out: a loop that switches through a long window
    then has none.
    """
    search = _Search(controller, name, simulation, heated, given or Effort())
    return None if given is None and search.is_coarse else search.found()


def band_percent(tolerance: float) -> tuple[float, float]:
    """Return the highest and the lowest power of a machine, in % of what its plant needs.

    Rounded outwards to two digits.
    """
    most = 100 * (1 + SPARE) / ((1 - tolerance) * SUPPLY[0] ** 2)
    least = 100 * (1 - SPARE) / ((1 + tolerance) * SUPPLY[1] ** 2)
    return math.ceil(most / 10) * 10.0, float(math.floor(least))


def sights(controller: Controller) -> Iterator[str]:
    """Report for each loop at which readings its effort rules can trip."""
    for name, loop in controller.loops.items():
        effort = loop.protection.effort
        if effort is None:
            continue
        low_c = [each for each in _degrees(loop) if effort.band.at(each)[1] > 0]
        high_c = high_trips_up_to_c(loop)
        told = {
            "effort_high": "" if high_c is None else f"up to {high_c} °C",
            "effort_low": f"from {low_c[0]} °C on" if low_c else "",
        }
        ends = {"effort_high": effort.high_percent, "effort_low": effort.low_percent}
        words = [
            f"{rule} can {f'trip {told[rule]}' if ends[rule] and told[rule] else 'never trip'}"
            for rule in ends
        ]
        yield f"{name}: {', '.join(words)}"


def high_trips_up_to_c(loop: Loop) -> int | None:
    """Return the highest reading at which effort_high can trip, °C; None if there is none."""
    effort, full = loop.protection.effort, loop.algorithm.full_percent
    if effort is None or effort.high_percent is None:
        return None
    return max((each for each in _degrees(loop) if effort.band.at(each)[0] < full), default=None)


def _degrees(loop: Loop) -> range:
    """Return the whole degrees between the fixed limits of a loop's reading, °C."""
    lowest_c, highest_c = loop.protection.minimum_c, loop.protection.maximum_c
    return range(math.ceil(lowest_c), math.floor(highest_c) + 1)


class _Corner(NamedTuple):
    """A corner of the tolerances: factors of the plant's values, and the ambient temperature."""

    capacity: float
    resistance: float
    power: float
    ambient_c: float


class _Search:
    """The search for a loop's band, and for the longest time of a healthy machine beyond it."""

    def __init__(
        self,
        controller: Controller,
        name: str,
        simulation: Simulation,
        heated: HeatedLoop,
        given: Effort,
    ) -> None:
        loop = controller.loops[name]
        self._heated, self._loop, self._given = heated, loop, given
        self._parts = (loop.heater, loop.sensor)
        self._plant = simulation.plant
        self._tolerance = simulation.plant.tolerance_percent / 100
        always = set(always_running(controller.outputs))
        coolers = {each.cooler for each in controller.loops.values()}
        self._windy, self._calm = always.copy(), always.copy()
        for fan, effect in simulation.plant.fans.items():
            if fan not in coolers:  # a cooler is never on together with its heater
                (self._windy if effect.factor >= 1 else self._calm).add(fan)
        self._fed = fed_plant(simulation.plant, _feed_mm_per_s(controller, simulation))
        noise_k = simulation.plant.sense[loop.sensor].noise_k
        self._move_k = max(
            LEAST_MOVE_K,
            LEAST_MOVE_STEPS * heated.step_k,
            SIGMAS * noise_k,
            SWINGS * loop.algorithm.swing_k,
        )
        middle_k = (heated.lowest_c + heated.highest_c) / 2 - heated.ambient_c
        lag_s, self._slow_s = heated.plant.lags_s(middle_k, TURNS)
        self._filter_s = min(max(lag_s, heated.period_s), heated.period_s / LEAST_SHARE)
        window_s = controller.switches[loop.heater].cycle_s
        self.is_coarse = loop.algorithm.swing_k > 0 and window_s > WINDOW_SHARE * self._filter_s

    def found(self) -> Effort | None:
        """Return the rule with all its numbers; None if it can never trip, or needs too long."""
        given, words = self._given, dict(self._given.derived)
        most, least = band_percent(self._tolerance)
        open_ = {key for field, key in _KEYS.items() if field not in given.model_fields_set}
        open_ |= set(given.derived)
        values: dict[str, float | None] = {}
        differs = (
            f"resistances that differ by {number(100 * self._tolerance)} %, a supply that is 15 % "
            "low or 10 % high"
        )
        if "high" in open_:
            values["high_percent"], words["high"] = most, differs
        if "low" in open_:
            values["low_percent"], words["low"] = least, differs
        rule = given.model_copy(update=values)
        band = self._band(rule)
        high = band.at((self._heated.lowest_c + self._heated.highest_c) / 2)[0]
        low = band.at(self._heated.highest_c)[1]
        if "high" in open_ and high >= self._loop.algorithm.full_percent:
            rule = rule.model_copy(update={"high_percent": None})
        if "low" in open_ and low <= 0:
            rule = rule.model_copy(update={"low_percent": None})
        if rule.high_percent is rule.low_percent is None:
            return None  # no power would be too much, or too little
        band = self._band(rule)
        if "for" in open_:
            longest_s = self._longest_s(band)
            most_s = max(TIMES * longest_s, FILTERS * self._filter_s)
            needs_s = most_s + self._heated.late_s
            for_s = self._heated.rounded_s(needs_s, SHORTEST_S)
            if for_s < needs_s:
                return None  # longer than can be counted, or too long to protect anything
            rule = rule.model_copy(update={"for_s": for_s})
            words["for"] = (
                f"a healthy machine is beyond a limit for up to {about(longest_s)} s; "
                f"{number(TIMES)} times that, or half of the plant's response time to a "
                f"power, {about(self._filter_s)} s, and delays"
            )
        return rule.derived_as(words).with_band(band)

    def _band(self, rule: Effort) -> EffortBand:
        return EffortBand(self._filter_s, self._move_k, tuple(self._lines(rule)))

    def _lines(self, rule: Effort) -> Iterator[EffortLine]:
        """Return the limits as straight lines over the reading, as few as are exact enough."""
        winter_c = min(WINTER_C, self._loop.protection.minimum_c)  # no limit is below 0 %
        winter = Heated(self._fed, *self._parts, winter_c, sorted(self._windy))
        summer = Heated(self._plant, *self._parts, SUMMER_C, sorted(self._calm))
        warm_k = SUN_K + (1 + self._tolerance) * self._heated.warmed_k
        most, least = (
            None if each is None else each / self._heated.power_w
            for each in (rule.high_percent, rule.low_percent)
        )

        def limits(celsius: float) -> tuple[float, float]:
            high, low = math.inf, -math.inf
            if most is not None:
                high = most * winter.power_w(celsius - winter_c)
            if least is not None:
                low = least * summer.power_w(celsius - SUMMER_C - warm_k)
            return high, low

        low_c, high_c = winter_c, self._loop.protection.maximum_c
        for count in range(1, MOST_LINES + 1):
            points = [low_c + (high_c - low_c) * i / count for i in range(count + 1)]
            lines = [_line(limits, *ends) for ends in pairwise(points)]
            middles = [(a + b) / 2 for a, b in pairwise(points)]
            if not self._plant.radiation or all(
                exact == straight or abs(exact - straight) <= BEND_PERCENT
                for line, middle_c in zip(lines, middles, strict=True)
                for exact, straight in zip(limits(middle_c), line.at(middle_c), strict=True)
            ):
                break
        yield from lines

    def _longest_s(self, band: EffortBand) -> float:
        """Return how long a healthy machine can be beyond its band, at the worst corner, s."""
        low, high = 1 - self._tolerance, 1 + self._tolerance
        longest_s = 0.0
        for capacity, resistance in ((low, low), (low, high), (high, low), (high, high)):
            for power, ambient_c in ((SUPPLY[0] ** 2, WINTER_C), (SUPPLY[1] ** 2, SUMMER_C)):
                corner = _Corner(capacity, resistance, power, ambient_c)
                longest_s = max(longest_s, self._beyond_s(corner, band))
        return longest_s

    def _beyond_s(self, corner: _Corner, band: EffortBand) -> float:
        """Return the longest time beyond the band, s: heating, reset, cooling, switching off."""
        weak = corner.power < 1
        network = _scaled(self._fed if weak else self._plant, corner.capacity, corner.resistance)
        running = sorted(self._windy if weak else self._calm)
        plant = Heated(network, *self._parts, corner.ambient_c, running)
        full_w = self._heated.full_w * corner.power
        reaches_c = corner.ambient_c + plant.steady_k(full_w)
        top_c = min(
            self._heated.highest_c, corner.ambient_c + 0.95 * (reaches_c - corner.ambient_c)
        )
        if top_c <= corner.ambient_c:
            return 0.0
        slow_s = self._slow_s * corner.capacity * corner.resistance
        step_s = SLOW_TIMES * slow_s / POINTS
        half_k = self._loop.algorithm.swing_k / 2
        course = _Course(plant, self._heated, corner, band, step_s, half_k)
        cold = plant.start(0.0)
        up_s, arrived, rested = course.follow(cold, top_c)
        bottom_c = max(self._heated.lowest_c, corner.ambient_c)
        longest_s = max(up_s, course.follow(rested, bottom_c)[0])
        # At a lower setpoint a large body takes heat while it is cold, or gives it while it is hot.
        for each in range(1, SETPOINTS if corner.capacity > 1 else 1):
            setpoint_c = bottom_c + (top_c - bottom_c) * each / SETPOINTS
            longest_s = max(longest_s, course.follow(cold if weak else rested, setpoint_c)[0])
        if weak:  # a reset while everything except the sensor is cold
            return max(longest_s, course.follow(arrived, top_c)[0])
        # After cooling in a warm room the reading is steady without power.
        off_s = (course.follow(each, None)[0] for each in course.off(rested, top_c))
        return max(longest_s, *off_s)


class _Course:
    """A healthy machine with ideal control, or switched around its setpoint."""

    def __init__(  # noqa: PLR0913, PLR0917 - each describes another part
        self,
        plant: Heated,
        heated: HeatedLoop,
        corner: _Corner,
        band: EffortBand,
        step_s: float,
        half_k: float,
    ) -> None:
        self._plant, self._band, self._step_s, self._half_k = plant, band, step_s, half_k
        self._ambient_c = corner.ambient_c
        self._full_w = heated.full_w * corner.power
        self._percent_per_w = 100 / (heated.power_w * corner.power)
        self._share = 1 - math.exp(-step_s / band.filter_s)

    def off(self, rested: Vector, top_c: float) -> Iterator[Vector]:
        """Yield states, after a steady state at a temperature, in which it may be switched off.

        From the second state, the fall to a reading that needs no power is just small enough to be
        ignored; but it is no hotter than a loop becomes that is switched on and off.
        """
        yield rested
        lowest_c, hottest_c = self._ambient_c, top_c + self._half_k
        highest_c = hottest_c
        if self._band.at(highest_c)[1] <= 0:
            return
        for _ in range(TURNS):
            middle_c = (lowest_c + highest_c) / 2
            if self._band.at(middle_c)[1] > 0:
                highest_c = middle_c
            else:
                lowest_c = middle_c
        stands_c = min(highest_c + STANDS * self._band.move_k, hottest_c)
        share = (stands_c - self._ambient_c) / self._plant.sensed_k(rested)
        yield [share * each for each in rested]

    def follow(self, state: Vector, target_c: float | None) -> tuple[float, Vector, Vector]:
        """Return how long a machine is beyond the band, s, its state on arrival, and its last one.

        target_c -- its setpoint; None: the heater is off. Infinite if it stays beyond the band.
        """
        plant, band = self._plant, self._band
        about_state = plant.snapped(state)
        without, added = plant.pushed(self._step_s, about_state)
        gain, arrived, sensed_c = plant.sensed_k(added), state, -math.inf
        effort, count, longest = 0.0, 0, 0
        from_c, is_there, is_on = -math.inf, False, True
        for place in range(2 * POINTS):
            if place >= POINTS and not count:
                break  # a loop that is switched may be beyond the band in the steady state
            if plant.bent(about_state, state):
                about_state = plant.snapped(state)
                without, added = plant.pushed(self._step_s, about_state)
                gain = plant.sensed_k(added)
            free, power_w = apply(without, state), 0.0
            if target_c is not None:
                wanted_w = (target_c - self._ambient_c - plant.sensed_k(free)) / gain
                power_w = min(max(wanted_w, 0.0), self._full_w)
                if self._half_k:
                    is_on = sensed_c < target_c + (self._half_k if is_on else -self._half_k)
                    power_w = self._full_w * is_on
                if wanted_w < self._full_w and not is_there:
                    arrived, is_there = state, True
            state = [old + power_w * each for old, each in zip(free, added, strict=True)]
            effort += self._share * (power_w * self._percent_per_w - effort)
            sensed_c = self._ambient_c + plant.sensed_k(state)
            high, low = band.at(sensed_c)
            if low <= effort <= high:
                from_c, count = sensed_c, 0
            elif abs(sensed_c - from_c) >= band.move_k:
                from_c, effort, count = sensed_c, min(max(effort, low), high), 0
            else:
                count += 1
                longest = max(longest, count)
        return (math.inf if count else longest * self._step_s), arrived, state


_KEYS = {"high_percent": "high", "low_percent": "low", "for_s": "for"}


def _line(
    limits: Callable[[float], tuple[float, float]], low_c: float, high_c: float
) -> EffortLine:
    """Return the straight line between two temperatures; an infinite limit has no slope."""
    numbers = []
    for here, there in zip(limits(low_c), limits(high_c), strict=True):
        per_k = (there - here) / (high_c - low_c) if math.isfinite(here) else 0.0
        numbers += [here - per_k * low_c, per_k]
    return EffortLine(low_c, *numbers)


def _feed_mm_per_s(controller: Controller, simulation: Simulation) -> float:
    """Return the fastest feed of steppers and scenario, mm/s."""
    speeds = [each.maximum_mm_per_s for each in controller.steppers.values()]
    asked = [each.extrude_mm_per_s for each in simulation.scenario if each.extrude_mm_per_s]
    return max([0.0, *speeds, *asked])


def _scaled(plant: ThermalNetwork, capacity: float, resistance: float) -> ThermalNetwork:
    """Return the plant with its capacities and its resistances multiplied by a factor each."""
    return plant.model_copy(
        update={
            "nodes": {name: capacity * value for name, value in plant.nodes.items()},
            "links": tuple(
                each.model_copy(update={"resistance_k_per_w": resistance * each.resistance_k_per_w})
                for each in plant.links
            ),
            "radiation": tuple(
                each.model_copy(update={"area_m2": each.area_m2 / resistance})
                for each in plant.radiation
            ),
        }
    )
