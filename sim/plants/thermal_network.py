"""Heat capacities joined by thermal resistances.

For every node i with capacity C_i:

    C_i · dT_i/dt = Σ_j (T_j − T_i) / R_ij + Q_i

plus radiation between surfaces (heatwright.sim.plants.radiation).
Ambient is a node of fixed temperature. A sensor follows its node with a first-order lag,
τ · dy/dt = T − y, a dead time and Gaussian noise. A current sensor shows the mean current of a
step after a first-order filter. A fan multiplies the conductance of a link by a factor; at an
active fraction f by 1 + (factor − 1)·f. Filament that is fed at v mm/s removes
heat · (T − T_ambient) · v from its node, like a conductance to ambient of heat · v.

The step is exact for heat that is constant over it: [x; u] goes through the matrix exponential of
the augmented system (Åström & Wittenmark, Computer-Controlled Systems, 1997, chapter 2).
"""

from collections.abc import Mapping
from copy import deepcopy
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from heatwright.sim.plants.radiation import Surface
from heatwright.sim.plants.sensing import Ammeter, Feeler
from heatwright.spec import ThermalNetwork

Matrix = NDArray[np.float64]

AMBIENT = "ambient"
MOST_STEP_MATRICES = 1024
"""One matrix is kept for each state of fans, feed and radiation: at most a few hundred occur."""


class Plant:
    """A thermal network that advances in equal steps of time."""

    def __init__(  # noqa: PLR0913 – all but two are named
        self,
        network: ThermalNetwork,
        powers_w: Mapping[str, float],
        *,
        ambient_c: float,
        step_s: float,
        seed: int = 0,
        full_a: Mapping[str, float] | None = None,
        starts_c: Mapping[str, float] | None = None,
        errors: Mapping[str, float] | None = None,
    ) -> None:
        """Set the network to its initial temperature.

        network -- the specification; powers_w -- power of each output when active, W; ambient_c --
        ambient temperature, °C; step_s -- time step, s; seed -- seed of the noise; full_a --
        current when active, A, of each output whose current is measured; starts_c -- temperatures
        of nodes that start at another temperature, °C; errors -- constant errors by sensor: of a
        tip in K, of a current as a share of it.
        """
        self.nodes = tuple(network.nodes)
        self.heaters, self.fans = tuple(network.heat), tuple(network.fans)
        self._network = network
        self._step_s = step_s
        errors = errors or {}
        self.heaters_w = tuple((name, powers_w[name]) for name in network.heat)
        tips = {name: sense for name, sense in network.sense.items() if sense.node is not None}
        self._lagging = tuple(name for name, sense in tips.items() if sense.lag_s > 0)
        self.states = len(self.nodes) + len(self._lagging)
        initial_c = ambient_c if network.initial_c is None else network.initial_c
        self._radiant = self.states + len(self.heaters_w)
        self.vector = np.full(self._radiant + len(network.radiation) + 1, initial_c)
        self.vector[-1] = ambient_c
        for node, start_c in (starts_c or {}).items():
            self.vector[self.nodes.index(node)] = start_c
        for place, name in enumerate(self._lagging, len(self.nodes)):
            self.vector[place] = self.vector[self._node_of(name)]
        self.surfaces = tuple(
            Surface.of(each, [self._place(node) for node in each.between])
            for each in network.radiation
        )
        self._next = np.empty(self.states)
        self._matrices: dict[tuple[float, ...], Matrix] = {}
        self.feelers = {
            name: Feeler(
                self.state_of(name),
                sense,
                self.state_c(self.state_of(name)),
                step_s,
                (seed, number),
                errors.get(name, 0.0),
            )
            for number, (name, sense) in enumerate(tips.items())
        }
        self.ammeters = {
            name: Ammeter(sense, (full_a or {})[sense.of] * (1 + errors.get(name, 0.0)), step_s)
            for name, sense in network.sense.items()
            if sense.of is not None
        }

    def at(self, vector: Matrix) -> "Plant":
        """Return the same plant with another vector of states and inputs."""
        other = deepcopy(self)
        other.vector[:] = vector
        return other

    @property
    def temperatures_c(self) -> Matrix:
        """The present temperature of every node, °C."""
        return self.vector[: len(self.nodes)]

    def sensed_c(self) -> dict[str, float]:
        """Return the present temperature of every sensor's tip, °C."""
        return {name: feeler.felt_c for name, feeler in self.feelers.items()}

    def currents_a(self) -> dict[str, float]:
        """Return the present current at every current sensor, A."""
        return {name: meter.amperes for name, meter in self.ammeters.items()}

    def step(
        self,
        active: Mapping[str, float],
        feed_mm_per_s: float = 0.0,
        conducts: Mapping[str, float] | None = None,
    ) -> None:
        """Advance by one step: see `heatwright.sim.plants.Plant.step`."""
        for meter in self.ammeters.values():
            meter.follow((active if conducts is None else conducts)[meter.output])
        vector = self.vector
        for place, (name, power_w) in enumerate(self.heaters_w, self.states):
            vector[place] = active[name] * power_w
        fans = [active[name] for name in self.fans]
        radiates = self._radiate() if self.surfaces else ()
        matrix = self._matrices.get((feed_mm_per_s, *fans, *radiates))
        if matrix is None:
            matrix = self._remember(tuple(fans), feed_mm_per_s, radiates)
        np.dot(matrix, vector, out=self._next)
        vector[: self.states] = self._next
        states = self._next.tolist()
        for feeler in self.feelers.values():
            feeler.feel(states)

    def _radiate(self) -> tuple[float, ...]:
        """Set the surfaces' remaining heats, and return their conductances, W/K."""
        found, temperatures_c = [], self.vector.tolist()
        for place, surface in enumerate(self.surfaces, self._radiant):
            conductance, self.vector[place] = surface.now(temperatures_c)
            found.append(conductance)
        return tuple(found)

    def _remember(
        self, fans: tuple[float, ...], feed_mm_per_s: float, radiates: tuple[float, ...]
    ) -> Matrix:
        if len(self._matrices) >= MOST_STEP_MATRICES:
            self._matrices.clear()
        matrix = self.matrix(fans, feed_mm_per_s, radiates)
        self._matrices[feed_mm_per_s, *fans, *radiates] = matrix
        return matrix

    def matrix(
        self, fans: tuple[float, ...], feed_mm_per_s: float, radiates: tuple[float, ...]
    ) -> Matrix:
        """Return a step's matrix for the vector of states and inputs; see `rates`."""
        rates = self.rates(fans, feed_mm_per_s, radiates)
        return _known_matrix(rates.tobytes(), rates.shape, self._step_s)

    def state_of(self, sensor: str) -> int:
        """Return the index of the state that a sensor follows, before its dead time."""
        if sensor in self._lagging:
            return len(self.nodes) + self._lagging.index(sensor)
        return self._node_of(sensor)

    def state_c(self, place: int) -> float:
        """Return the present value of a state, °C."""
        return float(self.vector[place])

    def radiates_at(self, temperature_c: float) -> tuple[float, ...]:
        """Return the derivative of each surface's radiation at a temperature, W/K."""
        return tuple(surface.slope(temperature_c) for surface in self.surfaces)

    def rates(
        self, fans: tuple[float, ...], feed_mm_per_s: float = 0.0, radiates: tuple[float, ...] = ()
    ) -> Matrix:
        """Return the derivatives of the states by states and inputs, 1/s.

        fans -- active fraction of each fan; feed_mm_per_s -- speed of the filament; radiates --
        conductance of each surface that radiates, W/K; none radiates if left out.
        """
        rates = np.zeros((self.states, len(self.vector)))
        for link in self._network.links:
            self._join(
                rates, link.between, self._gain(link.between, fans) / link.resistance_k_per_w
            )
        filament = self._network.filament
        if filament is not None:
            conductance_w_per_k = filament.heat_j_per_k_mm * feed_mm_per_s
            self._join(rates, (filament.node, AMBIENT), conductance_w_per_k)
        for place, (each, conductance) in enumerate(
            zip(self._network.radiation, radiates, strict=False), self._radiant
        ):
            self._join(rates, each.between, conductance)
            self._heat(rates, each.between, place)
        for place, node in enumerate(self._network.heat.values(), self.states):
            number = self.nodes.index(node)
            rates[number, place] = 1 / self._network.nodes[node]
        for state, sensor in enumerate(self._lagging, len(self.nodes)):
            sense = self._network.sense[sensor]
            rates[state, self._node_of(sensor)] = 1 / sense.lag_s
            rates[state, state] = -1 / sense.lag_s
        return rates

    def _node_of(self, sensor: str) -> int:
        node = self._network.sense[sensor].node
        assert node is not None  # noqa: S101 - each sensor of a temperature has one
        return self.nodes.index(node)

    def _join(self, rates: Matrix, between: tuple[str, str], conductance_w_per_k: float) -> None:
        for here, there in (between, between[::-1]):
            if here == AMBIENT:
                continue
            row = self.nodes.index(here)
            other = -1 if there == AMBIENT else self.nodes.index(there)
            rates[row, other] += conductance_w_per_k / self._network.nodes[here]
            rates[row, row] -= conductance_w_per_k / self._network.nodes[here]

    def _heat(self, rates: Matrix, between: tuple[str, str], place: int) -> None:
        """Let an input move heat from the second of two nodes to the first."""
        for node, sign in zip(between, (1.0, -1.0), strict=True):
            if node != AMBIENT:
                rates[self.nodes.index(node), place] = sign / self._network.nodes[node]

    def _place(self, node: str) -> int:
        """Return the index of a node's temperature in the vector."""
        return len(self.vector) - 1 if node == AMBIENT else self.nodes.index(node)

    def _gain(self, between: tuple[str, str], fans: tuple[float, ...]) -> float:
        gain = 1.0
        for effect, fraction in zip(self._network.fans.values(), fans, strict=True):
            if set(effect.link) == set(between):
                gain *= 1 + (effect.factor - 1) * fraction
        return gain


@lru_cache(maxsize=MOST_STEP_MATRICES)
def _known_matrix(rates: bytes, shape: tuple[int, int], step_s: float) -> Matrix:
    """Return the `step_matrix` of these rates, cached: many machines have the same rates."""
    matrix = step_matrix(np.frombuffer(rates).reshape(shape), shape[0], step_s)
    return np.ascontiguousarray(matrix)


def step_matrix(rates: Matrix, states: int, step_s: float) -> Matrix:
    """Integrate dx/dt = rates · [x; u] over a step with constant u: x_next = result · [x; u]."""
    augmented = np.zeros((rates.shape[1], rates.shape[1]))
    augmented[:states] = rates
    return np.asarray(expm(augmented * step_s))[:states]
