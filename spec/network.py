"""A thermal network solved: where it ends, how it rises, how it answers a swing of power.

Temperatures are above ambient, so that the network is linear: with capacities C and conductances
G (the network's Laplacian, ambient left out), C·dθ/dt = P − G·θ. A sensor follows its node with
a first-order lag. All in plain Python, for the networks are small and loading must be quick.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from heatwright.spec.simulation import AMBIENT, ThermalNetwork

Number = float | complex
Matrix = list[list[float]]
Vector = list[float]


def solve(matrix: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
    """Solve a system of linear equations by elimination with pivots."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for column in range(size):
        pivot = max(range(column, size), key=lambda row: abs(rows[row][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        for below in range(column + 1, size):
            factor = rows[below][column] / rows[column][column]
            if factor:
                for k in range(column, size + 1):
                    rows[below][k] -= factor * rows[column][k]
    found: list[Number] = [0.0] * size
    for row in reversed(range(size)):
        rest = sum(rows[row][k] * found[k] for k in range(row + 1, size))
        found[row] = (rows[row][size] - rest) / rows[row][row]
    return found


def product(left: Matrix, right: Matrix) -> Matrix:
    """Multiply two square matrices."""
    columns = list(zip(*right, strict=True))
    return [[sum(map(float.__mul__, row, column)) for column in columns] for row in left]


def apply(matrix: Matrix, vector: Vector) -> Vector:
    """Multiply a matrix by a vector."""
    return [sum(map(float.__mul__, row, vector)) for row in matrix]


def exponential(matrix: Matrix) -> Matrix:
    """Raise e to a square matrix: halve it to a norm below 1, sum the series, square it back."""
    size = range(len(matrix))
    norm = max(sum(map(abs, row)) for row in matrix)
    halvings = max(0, math.frexp(norm)[1])
    scaled = [[value / 2.0**halvings for value in row] for row in matrix]
    total = [[float(i == j) for j in size] for i in size]
    term = total
    for order in range(1, 18):  # 1/18! is below the last bit of 1
        term = [[value / order for value in row] for row in product(term, scaled)]
        total = [
            [a + b for a, b in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)
        ]
    for _ in range(halvings):
        total = product(total, total)
    return total


class Heated:
    """A network with one heater's power going to one node and one sensor watching another."""

    def __init__(
        self, network: ThermalNetwork, heat: str, sensor: str, running: Sequence[str] = ()
    ) -> None:
        """Take the node of output `heat`, the place of `sensor` and the fans that run."""
        self._nodes = list(network.nodes)
        self._capacities = [network.nodes[node] for node in self._nodes]
        self._conductances = _laplacian(network, self._nodes, running)
        self._heated = self._nodes.index(network.heat[heat])
        sense = network.sense[sensor]
        assert sense.node is not None  # noqa: S101 - a loop goes by a thermometer
        self._sensed = self._nodes.index(sense.node)
        self.lag_s = sense.lag_s
        self.delay_s = sense.delay_s

    def steady_k(self, power_w: float) -> float:
        """Temperature at the sensor above ambient, after any length of time at this power."""
        powers = [power_w if i == self._heated else 0.0 for i in range(len(self._nodes))]
        return float(solve(self._conductances, powers)[self._sensed].real)

    def swing_k(self, power_w: float, window_s: float) -> float:
        """Peak-to-peak swing at the sensor when the power is on for half of each window.

        The fundamental alone: a square wave of power P has one of amplitude 2·P/π, and the
        network and the lag leave little of its harmonics.
        """
        omega = 2 * math.pi / window_s
        size = range(len(self._nodes))
        matrix = [
            [
                self._conductances[i][j] + (1j * omega * self._capacities[i] if i == j else 0)
                for j in size
            ]
            for i in size
        ]
        powers = [2 * power_w / math.pi if i == self._heated else 0.0 for i in size]
        amplitude = abs(solve(matrix, powers)[self._sensed]) / abs(1 + 1j * omega * self.lag_s)
        return float(2 * amplitude)

    def fastest_s(self) -> float:
        """Time in which the quickest part of the network or its sensor answers."""
        quickest = max(
            conductances[i] / capacity
            for i, (conductances, capacity) in enumerate(
                zip(self._conductances, self._capacities, strict=True)
            )
        )
        return min(1 / quickest, self.lag_s) if self.lag_s else 1 / quickest

    def start(self, above_ambient_k: float) -> Vector:
        """State with every node, and the sensor, at one temperature; the last entry is 1."""
        return [above_ambient_k] * (len(self._nodes) + bool(self.lag_s)) + [1.0]

    def sensed_k(self, state: Vector) -> float:
        """Temperature of the sensor above ambient."""
        return state[len(self._nodes)] if self.lag_s else state[self._sensed]

    def step(self, power_w: float, time_s: float) -> Matrix:
        """Matrix that takes a state on by `time_s` at a constant power; exact."""
        size = len(self._nodes)
        states = size + bool(self.lag_s) + 1
        matrix = [[0.0] * states for _ in range(states)]
        for i in range(size):
            for j in range(size):
                matrix[i][j] = -self._conductances[i][j] / self._capacities[i] * time_s
        matrix[self._heated][-1] = power_w / self._capacities[self._heated] * time_s
        if self.lag_s:
            matrix[size][self._sensed] = time_s / self.lag_s
            matrix[size][size] = -time_s / self.lag_s
        return exponential(matrix)

    def advance(self, state: Vector, power_w: float, time_s: float) -> Vector:
        """Take a state on by a time at a constant power."""
        return apply(self.step(power_w, time_s), state)

    def course(
        self, state: Vector, power_w: float, first_s: float, longest_s: float
    ) -> Iterator[tuple[float, Vector]]:
        """Go on from a state for ever, in steps that double now and then up to `longest_s`."""
        time_s, step_s = 0.0, min(first_s, longest_s)
        matrix = self.step(power_w, step_s)
        yield time_s, state
        while True:
            for _ in range(64):
                state = apply(matrix, state)
                time_s += step_s
                yield time_s, state
            if 2 * step_s <= longest_s:
                step_s *= 2
                matrix = product(matrix, matrix)


def _laplacian(network: ThermalNetwork, nodes: Sequence[str], running: Sequence[str]) -> Matrix:
    """Conductances: on the diagonal all of a node's, beside it minus those between two nodes."""
    index: Mapping[str, int] = {node: i for i, node in enumerate(nodes)}
    factors = {
        frozenset(effect.link): effect.factor
        for fan, effect in network.fans.items()
        if fan in running
    }
    matrix = [[0.0] * len(nodes) for _ in nodes]
    for link in network.links:
        conductance = factors.get(frozenset(link.between), 1.0) / link.resistance_k_per_w
        ends = [index[end] for end in link.between if end != AMBIENT]
        for i in ends:
            matrix[i][i] += conductance
        if len(ends) == 2:
            matrix[ends[0]][ends[1]] -= conductance
            matrix[ends[1]][ends[0]] -= conductance
    return matrix
