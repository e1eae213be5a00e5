"""Solves a thermal network: steady temperatures, courses, and the response to switched power.

Temperatures are above ambient: with capacities C and flows G·θ + c (the network's, ambient left
out; c comes from radiation alone), C·dθ/dt = P − G·θ − c. A sensor follows its node with a
first-order lag. All in plain Python, because the networks are small and loading must be quick.
"""

import math
from collections.abc import Iterator, Sequence
from operator import mul

from heatwright.spec.physics.heat_flows import HeatFlows
from heatwright.spec.physics.matrices import (
    Matrix,
    Number,
    Vector,
    apply,
    exponential,
    product,
    solve,
)
from heatwright.spec.simulation import ThermalNetwork

MOST_TRIES = 200
"""Maximum number of iterations of Newton's method. Far above the solution each reduces the
temperature by a quarter; close to it each doubles the number of correct digits."""

EXACT = 1e-12
"""Relative change of a result below which an iteration ends."""

MOST_HALVINGS = 12
"""Maximum number of halvings of a step: only absurd plants have a part that changes so fast."""


class Heated:
    """A network with one heater's power going to one node and one sensor watching another."""

    def __init__(
        self,
        network: ThermalNetwork,
        heat: str,
        sensor: str,
        ambient_c: float,
        running: Sequence[str] = (),
    ) -> None:
        """Use the node of the output `heat`, the node of `sensor` and the running fans."""
        nodes = list(network.nodes)
        self._capacities = [network.nodes[node] for node in nodes]
        self._flows = HeatFlows(network, nodes, running, ambient_c)
        self._heated = nodes.index(network.heat[heat])
        sense = network.sense[sensor]
        assert sense.node is not None  # noqa: S101 - a loop's sensor is a thermometer
        self._sensed = nodes.index(sense.node)
        self.lag_s = sense.lag_s
        self.delay_s = sense.delay_s

    def steady_k(self, power_w: float) -> float:
        """Return the temperature of the sensor above ambient in the steady state at a power, K."""
        return self._at_rest(len(self._capacities), power_w)[self._sensed]

    def nodes_k(self, power_w: float) -> Vector:
        """Return the temperatures of all nodes above ambient in the steady state at a power, K."""
        return self._at_rest(len(self._capacities), power_w)[:-1]

    def held_k(self, sensed_k: float) -> Vector:
        """Return the temperatures of all nodes above ambient while the sensor is held at one, K."""
        return self._at_rest(self._sensed, sensed_k)[:-1]

    def power_w(self, sensed_k: float) -> float:
        """Return the power that holds the sensor at a temperature above ambient, W."""
        return self._at_rest(self._sensed, sensed_k)[-1]

    def ramp_power_w(self, sensed_k: float, rate_k_per_s: float) -> float:
        """Return the power at which all nodes rise at one rate, W; the sensor is at `sensed_k`."""
        ahead_k = rate_k_per_s * self.lag_s
        return self._at_rest(self._sensed, sensed_k + ahead_k, rate_k_per_s)[-1]

    def rest(self, sensed_k: float) -> Vector:
        """Return the steady state with the sensor at a temperature above ambient."""
        *nodes, _ = self._at_rest(self._sensed, sensed_k)
        return [*nodes, *([sensed_k] if self.lag_s else []), 1.0]

    def _at_rest(self, given: int, value: float, rate_k_per_s: float = 0.0) -> Vector:
        """Find the nodes' temperatures, followed by the power; one of these values is given.

        All nodes are in the steady state, or rise at one rate.
        """
        size = len(self._capacities)
        found = [0.0] * (size + 1)
        for _ in range(MOST_TRIES):
            conductances, constants = self._flows.about(found)
            rows = [[*row, -float(i == self._heated)] for i, row in enumerate(conductances)]
            rows.append([float(i == given) for i in range(size + 1)])
            right = [
                -constant - capacity * rate_k_per_s
                for constant, capacity in zip(constants, self._capacities, strict=True)
            ]
            right.append(value)
            before, found = found, [each.real for each in solve(rows, right)]
            if self._flows.linear or alike(before, found):
                break
        return found

    def swing_k(self, power_w: float, window_s: float) -> float:
        """Return the sensor's peak-to-peak swing if the power is on for half of each window, K.

        Only the fundamental counts: that of a square wave of power P has the amplitude 2·P/π, and
        network and lag leave little of the harmonics. The network is linearized at ambient, where
        the least is radiated and the swing is widest.
        """
        omega = 2 * math.pi / window_s
        size = range(len(self._capacities))
        conductances, _ = self._flows.about(self.start(0.0))
        matrix = [
            [conductances[i][j] + (1j * omega * self._capacities[i] if i == j else 0) for j in size]
            for i in size
        ]
        powers = [2 * power_w / math.pi if i == self._heated else 0.0 for i in size]
        amplitude = abs(solve(matrix, powers)[self._sensed]) / abs(1 + 1j * omega * self.lag_s)
        return float(2 * amplitude)

    def fastest_s(self) -> float:
        """Return the shortest time constant of the network's nodes and the sensor's lag, s."""
        conductances, _ = self._flows.about(self.start(0.0))
        quickest = max(
            row[i] / capacity
            for i, (row, capacity) in enumerate(zip(conductances, self._capacities, strict=True))
        )
        return min(1 / quickest, self.lag_s) if self.lag_s else 1 / quickest

    def answer_s(self) -> float:
        """Return the time until the sensor responds to the heater, s: lags and dead time."""
        conductances, _ = self._flows.about(self.start(0.0))
        between = {self._heated, self._sensed}
        lags_s = [self._capacities[i] / conductances[i][i] for i in between]
        return sum(lags_s) + self.lag_s + self.delay_s

    def lags_s(self, sensed_k: float, turns: int) -> tuple[float, float]:
        """Return the sensor's mean response time to a change of power, and the slowest lag, s.

        The network is linearized at the steady state of a temperature above ambient. The slowest
        lag is found by inverse iteration from the steady rise that the heater causes.
        """
        size = len(self._capacities)
        conductances, _ = self._flows.about(self._at_rest(self._sensed, sensed_k))
        warmed = _real(solve(conductances, [float(i == self._heated) for i in range(size)]))
        rise, first_s, slow_s = warmed, 0.0, 0.0
        for turn in range(turns):
            later = _real(solve(conductances, list(map(mul, self._capacities, rise))))
            slow_s = max(later) / max(rise)
            if turn == 0:
                first_s = later[self._sensed] / rise[self._sensed]
            rise = [each / max(later) for each in later]
        return first_s + self.lag_s + self.delay_s, slow_s

    def start(self, above_ambient_k: float) -> Vector:
        """Return the state with all nodes and the sensor at a temperature; the last entry is 1."""
        return [above_ambient_k] * (len(self._capacities) + bool(self.lag_s)) + [1.0]

    def sensed_k(self, state: Vector) -> float:
        """Return the temperature of the sensor above ambient, K."""
        return state[len(self._capacities)] if self.lag_s else state[self._sensed]

    def step(self, power_w: float, time_s: float, about: Vector) -> Matrix:
        """Return the matrix that advances a state by `time_s` at a constant power.

        It is exact for conduction; radiation is replaced by its tangent at a state.
        """
        matrix = self._rates(time_s, about)
        matrix[self._heated][-1] += power_w / self._capacities[self._heated] * time_s
        return exponential(matrix)

    def pushed(self, time_s: float, about: Vector) -> tuple[Matrix, Vector]:
        """Return the matrix that advances a state without power, and what each watt adds to it."""
        matrix = [[*row, 0.0] for row in self._rates(time_s, about)]
        matrix[self._heated][-1] = time_s / self._capacities[self._heated]
        *found, _ = exponential([*matrix, [0.0] * len(matrix[0])])
        return [row[:-1] for row in found], [row[-1] for row in found]

    def _rates(self, time_s: float, about: Vector) -> Matrix:
        """Return the matrix of the state's rates of change without power, times `time_s`."""
        size = len(self._capacities)
        states = size + bool(self.lag_s) + 1
        conductances, constants = self._flows.about(about)
        matrix = [[0.0] * states for _ in range(states)]
        for i, capacity in enumerate(self._capacities):
            for j in range(size):
                matrix[i][j] = -conductances[i][j] / capacity * time_s
            matrix[i][-1] = -constants[i] / capacity * time_s
        if self.lag_s:
            matrix[size][self._sensed] = time_s / self.lag_s
            matrix[size][size] = -time_s / self.lag_s
        return matrix

    def snapped(self, state: Vector) -> Vector:
        """Return a state near by, the same one for many states, at which to linearize."""
        return self._flows.snapped(state)

    def bent(self, about: Vector, state: Vector) -> bool:
        """Return whether a state is too far from the one at which a matrix was linearized."""
        return self._flows.bent(about, state)

    def advance(self, state: Vector, power_w: float, time_s: float) -> Vector:
        """Advance a state by a time at a constant power."""
        return self._advance(state, power_w, time_s, MOST_HALVINGS)

    def _advance(self, state: Vector, power_w: float, time_s: float, halvings: int) -> Vector:
        """Advance a state in one step, or in two halves where the linearization is too inexact."""
        later = apply(self.step(power_w, time_s, self.snapped(state)), state)
        if halvings == 0 or not self._flows.bent(state, later):
            return later
        for _ in range(2):
            state = self._advance(state, power_w, time_s / 2, halvings - 1)
        return state

    def course(
        self, state: Vector, power_w: float, first_s: float, longest_s: float
    ) -> Iterator[tuple[float, Vector]]:
        """Yield times and states without end; after every 64 a step doubles, up to `longest_s`."""
        time_s, step_s = 0.0, min(first_s, longest_s)
        about, matrix = state, self.step(power_w, step_s, state)
        yield time_s, state
        while True:
            for _ in range(64):
                state = apply(matrix, state)
                time_s += step_s
                yield time_s, state
                if self._flows.bent(about, state):
                    about, matrix = state, self.step(power_w, step_s, state)
            if 2 * step_s <= longest_s:
                step_s *= 2
                matrix = product(matrix, matrix)


def _real(numbers: Sequence[Number]) -> Vector:
    return [each.real for each in numbers]


def alike(one: Vector, other: Vector) -> bool:
    """Return whether two results are equal within the tolerance of the iteration."""
    most = max(map(abs, other))
    return all(abs(a - b) <= EXACT * most for a, b in zip(one, other, strict=True))
