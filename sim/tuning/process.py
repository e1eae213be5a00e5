"""The linear model of a machine near a working point, from duty to reading, with its delays."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals, expm

from heatwright.sim.plants import powers_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import Controller
from heatwright.spec.registry import module_of

Matrix = NDArray[np.float64]

SAME = 1e-6
"""A pole and a zero with a smaller relative distance than this cancel."""


@dataclass(frozen=True)
class Process:
    """dx/dt = A·x + b·u, y = c·x; u in % of full power, y in K, with a dead time."""

    rates: Matrix
    """A, 1/s."""
    heat: Matrix
    """b, K/s for each % of duty."""
    reading: Matrix
    """c."""
    late_s: float
    """Sum of dead time, age of the readings, and delay of the duty, s."""

    @property
    def gain(self) -> float:
        """The steady-state gain, K/%."""
        return float(-self.reading @ np.linalg.solve(self.rates, self.heat))

    @property
    def lags_s(self) -> list[float]:
        """Time constants of the denominator, s, longest first, without those that cancel.

        All are real: a network of capacities and resistances does not oscillate.
        """
        return _times(self._poles_and_zeros()[0])

    @property
    def leads_s(self) -> list[float]:
        """Time constants of the numerator, s, longest first."""
        return _times(self._poles_and_zeros()[1])

    def held(self, time_s: float) -> tuple[Matrix, Matrix]:
        """Return the exact matrices of state and constant duty over a time."""
        size = len(self.rates)
        augmented = np.zeros((size + 1, size + 1))
        augmented[:size, :size] = self.rates
        augmented[:size, size] = self.heat
        power = expm(augmented * time_s)
        return power[:size, :size], power[:size, size]

    def _poles_and_zeros(self) -> tuple[list[float], list[float]]:
        poles = sorted(np.real(np.linalg.eigvals(self.rates)).tolist())
        zeros = sorted(_zeros(self.rates, self.heat, self.reading))
        for zero in tuple(zeros):
            near = min(poles, key=lambda pole: abs(pole - zero))
            if abs(near - zero) <= SAME * abs(zero):
                poles.remove(near)
                zeros.remove(zero)
        return poles, zeros


def _zeros(rates: Matrix, heat: Matrix, reading: Matrix) -> list[float]:
    """Find where [A − s·I, b; c, 0] is singular."""
    size = len(rates)
    system = np.block([[rates, heat[:, None]], [reading[None, :], np.zeros((1, 1))]])
    identity = np.zeros_like(system)
    identity[:size, :size] = np.eye(size)
    found = eigvals(system, identity)
    # Zeros at infinity are computed as huge numbers, or not at all.
    largest = np.abs(rates).max() / np.finfo(float).eps ** 0.5
    return [float(np.real(zero)) for zero in found if np.isfinite(zero) and abs(zero) < largest]


def _times(roots: list[float]) -> list[float]:
    return sorted((-1 / root for root in roots), reverse=True)


def power_of(controller: Controller, loop: str) -> float | None:
    """Return the power of a loop's heater at full duty, W; None if the spec does not give it."""
    return controller.outputs[controller.loops[loop].heater].power_w


def process_of(controller: Controller, loop: str, at_c: float | None = None) -> Process:
    """Linearise the machine of a spec, with the fans that always run.

    controller -- the specification; loop -- name of the loop; at_c -- temperature at which
    radiation is linearised, °C; the initial setpoint if None. Raises ValueError: the specification
    has no simulation, or its heater no power.
    """
    spec, network = controller.loops[loop], controller.simulated.plant
    power_w = power_of(controller, loop)
    if not power_w:
        raise ValueError(f"The heater {spec.heater} has no power")
    plant = Plant(network, powers_of(controller), ambient_c=0.0, step_s=spec.period_s)
    equations = plant.rates(
        tuple(float(_runs(controller, fan)) for fan in network.fans),
        radiates=plant.radiates_at(spec.setpoint.initial_c if at_c is None else at_c),
    )
    size = len(equations)
    sensed = plant.state_of(spec.sensor)
    kept = sorted({*range(len(plant.nodes)), sensed})
    heater = size + tuple(network.heat).index(spec.heater)
    late_s = (
        network.sense[spec.sensor].delay_s
        + reading_age_s(controller, spec.sensor)
        + spec.periods_s((controller.thermometers[spec.sensor].moving_average - 1) / 2)
        + output_delay_s(controller, spec.heater, spec.period_s)
    )
    return Process(
        equations[np.ix_(kept, kept)],
        equations[kept, heater] * power_w / 100,
        np.array([float(state == sensed) for state in kept]),
        late_s,
    )


def at_full_power(
    controller: Controller, loop: str, step_s: float
) -> Iterator[tuple[float, float]]:
    """Yield time, s, and temperature before the sensor's dead time, °C, from cold at full power.

    Raises ValueError: the specification has no simulation.
    """
    spec, simulation = controller.loops[loop], controller.simulated
    network = simulation.plant.model_copy(update={"initial_c": None})
    plant = Plant(network, powers_of(controller), ambient_c=simulation.ambient_c, step_s=step_s)
    active = {name: float(_runs(controller, name)) for name in controller.outputs}
    active[spec.heater] = spec.algorithm.full_percent / 100
    state, steps = plant.state_of(spec.sensor), 0
    while True:
        plant.step(active)
        steps += 1
        yield steps * step_s, plant.state_c(state)


def _runs(controller: Controller, fan: str) -> bool:
    return controller.outputs[fan].always_runs


def reading_age_s(controller: Controller, sensor: str) -> float:
    """Return how old a reading is at its control step, s."""
    spec = controller.sensors[sensor]
    module = import_module(module_of("sensor", "reference", spec.kind))
    return float(module.IdealSensor(spec, controller.board).sampled_before_step_s)


def output_delay_s(controller: Controller, output: str, period_s: float) -> float:
    """Return the mean delay until the output takes a new duty over, s.

    A PWM takes it over in its next period, a time-proportional output in its next window; a window
    as long as the control period begins with the step itself.
    """
    spec = controller.switches[output]
    if spec.frequency_hz:
        return 0.5 / spec.frequency_hz
    return max(0.0, spec.cycle_s - period_s) / 2
