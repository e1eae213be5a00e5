"""A loop with its part of the plant, heated to the highest setpoint and then left to cool."""

import math
from collections.abc import Iterator
from itertools import islice, pairwise

from heatwright.spec.checks.finding import Finding
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Switch, always_running, limit_w, waits_s
from heatwright.spec.physics.matrices import Vector
from heatwright.spec.physics.network import Heated
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, duration
from heatwright.spec.simulation import Simulation

MOST_POINTS = 5_000
"""Maximum number of points of a simulated course; only absurd plants and rules need more."""

MOST_POINTS_OF_A_FALL = 64
"""Points a quarter of the shortest time constant apart; the steepest fall is within them."""


class Machine:
    """One loop with its part of the plant."""

    def __init__(
        self, controller: Controller, name: str, heater: Switch, simulation: Simulation
    ) -> None:
        self.loop = controller.loops[name]
        self.path: Path = ("loops", name)
        self.output = heater
        self._sensor, self._mcu = controller.thermometers[self.loop.sensor], controller.board.mcu
        self.ambient_c = simulation.ambient_c
        running = always_running(controller.outputs)
        parts = self.loop.heater, self.loop.sensor
        self.plant = Heated(simulation.plant, *parts, self.ambient_c, running)
        self.cooler = controller.outputs.get(self.loop.cooler) if self.loop.cooler else None
        cooled = [*running, self.loop.cooler] if self.loop.cooler else running
        self.cooled = Heated(simulation.plant, *parts, self.ambient_c, cooled)
        start_c = simulation.plant.initial_c
        self.start_k = 0.0 if start_c is None else start_c - self.ambient_c
        # A sum of readings has the noise of their mean.
        summed = int(getattr(self._sensor, "oversample", 1))
        self.noise_k = simulation.plant.sense[self.loop.sensor].noise_k / math.sqrt(summed)
        self.readings = self._sensor.moving_average
        self.power_w = self.output.power_w or 0.0
        self.target_k = self.loop.setpoint.maximum_c - self.ambient_c
        self.because_of: tuple[Path, ...] = (
            self.path,
            ("outputs", self.loop.heater),
            ("simulation",),
        )
        # Times and temperatures at the sensor above ambient, from cold to the highest setpoint.
        self.course = tuple(self._heating()) if self.reaches else ()

    def finding(self, keys: Path, reason: str, remedy: str) -> Finding:
        """Make a finding about an entry of the loop."""
        return Finding((*self.path, *keys), reason, remedy, self.because_of)

    def step_k(self, above_ambient_k: float) -> float:
        """Step of the sensor's readings at a temperature above ambient, K."""
        step_k: float = self._sensor.step_at_k(self.ambient_c + above_ambient_k, self._mcu)
        return step_k

    def rates(self) -> Iterator[tuple[float, float]]:
        """Yield how fast the sensor's reading rises on the course, K/s, and its step there, K."""
        for (before_s, before_k), (after_s, after_k) in pairwise(self.course):
            rate_k_per_s = (after_k - before_k) / (after_s - before_s)
            yield rate_k_per_s, self.step_k(min(after_k, self.target_k))

    def seen(self, rate_k_per_s: float) -> float:
        """Return the highest rate that two readings may show for a real rate, K/s.

        If the chip converts by itself, the conversions of two readings may be up to one conversion
        further apart than a period.
        """
        return rate_k_per_s * (1 + self.loop.periods_in(self._sensor.free_running_s))

    def told(self, rate_k_per_s: float) -> str:
        """Format a rate, and the highest rate that two readings may show for it."""
        said = f"{about(rate_k_per_s)} K/s"
        if self._sensor.free_running_s:
            said += (
                f" (its readings can show {about(self.seen(rate_k_per_s))} K/s, as the chip "
                f"converts every {duration(self._sensor.free_running_s)})"
            )
        return said

    @property
    def pulse_w(self) -> float:
        """Power while the heater is on, W: more than the rated power where the supply is higher."""
        return self.power_w / self.output.full_share

    @property
    def full_power_w(self) -> float:
        """Highest power of the algorithm, or of the current limit if that is lower, W."""
        share = self.loop.algorithm.full_percent / 100
        return min(self.power_w * share, limit_w(self.output))

    @property
    def limit_a(self) -> float:
        """Limit of the heater's current, A; infinite if there is none."""
        current = self.output.current
        return math.inf if current is None or current.limit_a is None else float(current.limit_a)

    @property
    def is_limited(self) -> bool:
        """True if the current limit, and not the algorithm, decides the full power."""
        return self.full_power_w == limit_w(self.output)

    @property
    def reaches(self) -> bool:
        """True if full power ends above the highest setpoint."""
        return self.plant.steady_k(self.full_power_w) > self.target_k

    @property
    def held_on_s(self) -> float:
        """Longest time for which the heater may stay on after the algorithm switches it off, s."""
        return self.output.stays_on_s

    @property
    def held_off_s(self) -> float:
        """Longest time for which the heater may have to wait before it is on, s.

        The heater waits for its own pause or windows, or for the cooler's shortest time on.
        """
        return max(waits_s(self.output), self.cooler_held_on_s)

    @property
    def cooler_held_on_s(self) -> float:
        """Longest time for which the cooler may stay on after the algorithm switches it off, s."""
        return self.cooler.stays_on_s if self.cooler else 0.0

    def _heating(self) -> Iterator[tuple[float, float]]:
        quick_s = self.plant.fastest_s() / 4
        rule = self.loop.protection.heating
        longest_s = rule.within_s / 16 if rule is not None else 64 * quick_s
        self._hot = self.plant.start(self.start_k)
        course = self.plant.course(self._hot, self.full_power_w, quick_s, longest_s)
        for time_s, state in islice(course, MOST_POINTS):
            self._hot = state
            yield time_s, self.plant.sensed_k(state)
            if self.plant.sensed_k(state) >= self.target_k:
                return

    @property
    def _seen_late_s(self) -> float:
        """Delay from the sensor to the step's action: dead time, averaging and a period, s."""
        behind_s = self.loop.periods_s((self._sensor.moving_average - 1) / 2)
        return self.loop.next_step_s(self.plant.delay_s + behind_s)

    def coasting(self) -> Iterator[tuple[float, float]]:
        """Yield times and temperatures after the heater went off at the highest setpoint.

        The heater goes off late: the reading is one dead time old, an average is late by half its
        readings, the next step is up to a period away, and the heater may have a shortest time on.
        """
        late_s = self._seen_late_s + self.held_on_s
        state: Vector = self.plant.advance(self._hot, self.full_power_w, late_s)
        highest_k = self.plant.sensed_k(state)
        quick_s = self.plant.fastest_s() / 4
        course = self.plant.course(state, 0.0, quick_s, 64 * quick_s)
        for time_s, later in islice(course, MOST_POINTS):
            sensed_k = self.plant.sensed_k(later)
            yield time_s, sensed_k
            if sensed_k < highest_k:
                return
            highest_k = sensed_k

    def cooling(self) -> Iterator[tuple[float, float]]:
        """Yield times and temperatures with the cooler on, from all nodes at the highest setpoint.

        The fall is steepest in the beginning, as soon as the sensor follows.
        """
        quick_s = self.cooled.fastest_s() / 4
        state = self.cooled.start(self.target_k)
        course = self.cooled.course(state, 0.0, quick_s, 64 * quick_s)
        for time_s, later in islice(course, MOST_POINTS_OF_A_FALL):
            yield time_s, self.cooled.sensed_k(later)

    def falling(self, from_k: float, lead_s: float) -> Iterator[tuple[float, float]]:
        """Yield times and temperatures from the highest setpoint down, and up again.

        The loop asks for heat `lead_s` before the reading is at `from_k`. The heat comes late, see
        `coasting`, and the heater may have to wait. The machine has just warmed up: its other parts
        are still cold, and take heat away.
        """
        late_s = self._seen_late_s + self.held_off_s - lead_s
        quick_s = self.plant.fastest_s() / 4
        since_s, state, asked_s = 0.0, self._hot, math.inf
        for time_s, later in islice(self.plant.course(state, 0.0, quick_s, quick_s), MOST_POINTS):
            state, since_s = later, time_s
            yield time_s, self.plant.sensed_k(state)
            if asked_s == math.inf and self.plant.sensed_k(state) <= from_k:
                asked_s = time_s
            if time_s >= asked_s + late_s:
                break
        course = self.plant.course(state, self.full_power_w, quick_s, quick_s)
        for time_s, later in islice(course, MOST_POINTS):
            yield since_s + time_s, self.plant.sensed_k(later)
            if self.plant.sensed_k(later) >= from_k:
                return

    def rise_k(self, time_s: float) -> float:
        """Rise at full power within a time, from the lowest setpoint, where it is fastest, K."""
        cold_k = max(self.loop.setpoint.minimum_c - self.ambient_c, 0.0)
        warm = self.plant.advance(self.plant.start(cold_k), self.full_power_w, time_s)
        return self.plant.sensed_k(warm) - cold_k

    def fall_k(self, time_s: float) -> float:
        """Fall with the cooler on within a time, from the highest setpoint, where fastest, K."""
        cold = self.cooled.advance(self.cooled.start(self.target_k), 0.0, time_s)
        return self.target_k - self.cooled.sensed_k(cold)
