"""One loop with its part of the plant, heated to the highest setpoint and let go."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from heatwright.spec.algorithms import Pid
from heatwright.spec.controller import Controller
from heatwright.spec.network import Heated, Vector
from heatwright.spec.outputs import DigitalOutput, Switch
from heatwright.spec.problems import Path
from heatwright.spec.simulation import Simulation

MOST_POINTS = 5_000
"""Points of a course that are followed; only absurd plants and rules have more."""


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
        running = [
            fan
            for fan, output in controller.outputs.items()
            if isinstance(output, DigitalOutput) and output.runs == "always"
        ]
        self.plant = Heated(simulation.plant, self.loop.heater, self.loop.sensor, running)
        start_c = simulation.plant.initial_c
        self._start_k = 0.0 if start_c is None else start_c - self.ambient_c
        self.power_w = self.output.power_w or 0.0
        self.target_k = self.loop.setpoint.maximum_c - self.ambient_c
        self.because_of: tuple[Path, ...] = (
            self.path,
            ("outputs", self.loop.heater),
            ("simulation",),
        )
        # Times and temperatures at the sensor above ambient, from cold to the highest setpoint.
        self.course = tuple(self._heating()) if self.reaches else ()

    def step_k(self, above_ambient_k: float) -> float:
        """Step of the sensor's readings about a temperature."""
        step_k: float = self._sensor.step_at_k(self.ambient_c + above_ambient_k, self._mcu)
        return step_k

    @property
    def full_power_w(self) -> float:
        """The most the algorithm asks for."""
        algorithm = self.loop.algorithm
        share = algorithm.output.maximum_percent / 100 if isinstance(algorithm, Pid) else 1.0
        return self.power_w * share

    @property
    def reaches(self) -> bool:
        """True if full power ends above the highest setpoint."""
        return self.plant.steady_k(self.full_power_w) > self.target_k

    def _heating(self) -> Iterator[tuple[float, float]]:
        quick_s = self.plant.fastest_s() / 4
        rule = self.loop.protection.heating
        longest_s = rule.within_s / 16 if rule is not None else 64 * quick_s
        self._hot = self.plant.start(self._start_k)
        course = self.plant.course(self._hot, self.full_power_w, quick_s, longest_s)
        for time_s, state in islice(course, MOST_POINTS):
            self._hot = state
            yield time_s, self.plant.sensed_k(state)
            if self.plant.sensed_k(state) >= self.target_k:
                return

    def coasting(self) -> Iterator[tuple[float, float]]:
        """Yield times and temperatures after the heater went off at the highest setpoint.

        It goes off late: the reading is one dead time old, and the step up to a period away.
        """
        late_s = self.plant.delay_s + self.loop.period_s
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
