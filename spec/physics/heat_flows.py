"""Heat flows between the nodes of a network: by conduction, and by radiation.

Conduction is linear. Radiation, σ·ε·A·(Ta⁴ − Tb⁴) in kelvin, is replaced by its tangent at a state:
q ≈ q₀ + ga·(θa − θa₀) − gb·(θb − θb₀) with g = 4·σ·ε·A·T³.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

from heatwright.spec.base import ABSOLUTE_ZERO_C
from heatwright.spec.physics.matrices import Matrix, Vector
from heatwright.spec.simulation import AMBIENT, Radiation, ThermalNetwork

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m²·K⁴) (CODATA 2018, exact)."""

BEND = 0.01
"""Relative change of an absolute temperature for which a tangent is exact enough: its error is
6·0.01² of T⁴, and less of the flow; messages show three digits."""

COLDEST_K = 1.0


class HeatFlows:
    """The heat that leaves each node, as a matrix of conductances and a constant part."""

    def __init__(
        self,
        network: ThermalNetwork,
        nodes: Sequence[str],
        running: Sequence[str],
        ambient_c: float,
    ) -> None:
        """Use the links that result from the running fans, and the radiating surfaces."""
        self._index: Mapping[str, int] = {node: i for i, node in enumerate(nodes)}
        self._conduction = self._laplacian(network, running)
        self._radiation = network.radiation
        radiating = (i for each in network.radiation for i, _ in self._ends(each))
        self._radiating = tuple(dict.fromkeys(radiating))
        self._ambient_k = ambient_c - ABSOLUTE_ZERO_C
        self.linear = not network.radiation

    def about(self, state: Vector) -> tuple[Matrix, Vector]:
        """Return conductances G, W/K, and constants c, W, of the flows G·θ + c at a state."""
        conductances = [row[:] for row in self._conduction]
        constants = [0.0] * len(conductances)
        for surface in self._radiation:
            self._add(conductances, constants, state, surface)
        return conductances, constants

    def snapped(self, state: Vector) -> Vector:
        """Return a state near by, the same one for many states, so that matrices can be reused."""
        near = [*state]
        for i in self._radiating:
            kelvin = self._kelvin(state[i])
            place = round(math.log(kelvin) / math.log1p(BEND))
            near[i] = (1 + BEND) ** place - self._ambient_k
        return near

    def bent(self, about: Vector, state: Vector) -> bool:
        """Return whether a state is too far from the tangents' state for them to be exact."""
        for i in self._radiating:  # called at every step: a generator takes three times as long
            if abs(state[i] - about[i]) > BEND * self._kelvin(about[i]):
                return True
        return False

    def _kelvin(self, above_ambient_k: float) -> float:
        """Return an absolute temperature, K, at least COLDEST_K: at 0 K radiation has no slope."""
        return max(self._ambient_k + above_ambient_k, COLDEST_K)

    def _ends(self, surface: Radiation) -> Iterator[tuple[int, float]]:
        """List the ends that are nodes, with the direction in which the flow counts there."""
        for end, sign in zip(surface.between, (1.0, -1.0), strict=True):
            if end != AMBIENT:
                yield self._index[end], sign

    def _add(
        self, conductances: Matrix, constants: Vector, state: Vector, surface: Radiation
    ) -> None:
        factor = STEFAN_BOLTZMANN * surface.emissivity * surface.area_m2
        kelvins = [
            self._kelvin(0.0 if end == AMBIENT else state[self._index[end]])
            for end in surface.between
        ]
        flow_w = factor * (kelvins[0] ** 4 - kelvins[1] ** 4)
        ends = dict(self._ends(surface))
        slopes = {i: sign * 4 * factor * self._kelvin(state[i]) ** 3 for i, sign in ends.items()}
        rest_w = flow_w - sum(slope * state[i] for i, slope in slopes.items())
        for i, sign in ends.items():
            constants[i] += sign * rest_w
            for j, slope in slopes.items():
                conductances[i][j] += sign * slope

    def _laplacian(self, network: ThermalNetwork, running: Sequence[str]) -> Matrix:
        """Return a matrix: a node's conductances, summed on the diagonal, negative beside it."""
        factors: dict[frozenset[str], float] = {}
        for fan, effect in network.fans.items():
            if fan in running:
                ends = frozenset(effect.link)
                factors[ends] = factors.get(ends, 1.0) * effect.factor
        matrix = [[0.0] * len(self._index) for _ in self._index]
        for link in network.links:
            conductance = factors.get(frozenset(link.between), 1.0) / link.resistance_k_per_w
            nodes = [self._index[end] for end in link.between if end != AMBIENT]
            for i in nodes:
                matrix[i][i] += conductance
            if len(nodes) == 2:
                matrix[nodes[0]][nodes[1]] -= conductance
                matrix[nodes[1]][nodes[0]] -= conductance
        return matrix
