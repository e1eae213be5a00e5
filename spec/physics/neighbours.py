"""The rise of a loop's sensor by the heaters of other loops, while its own heater is off."""

from collections.abc import Sequence
from typing import NamedTuple

from heatwright.spec.physics.heat_flows import HeatFlows
from heatwright.spec.physics.matrices import solve
from heatwright.spec.physics.network import MOST_TRIES, alike
from heatwright.spec.simulation import AMBIENT, ThermalNetwork


class Neighbour(NamedTuple):
    """Another loop that holds a temperature."""

    heater: str
    sensor: str
    above_ambient_k: float


def warmed_k(
    network: ThermalNetwork,
    sensor: str,
    neighbours: Sequence[Neighbour],
    ambient_c: float,
    running: Sequence[str],
) -> float:
    """Return how far above ambient a sensor rises by its neighbours' heat alone, K.

    Each neighbour heats its own sensor to the temperature that it holds; it is off if the others
    heat that sensor more.
    Raises ArithmeticError: two neighbours hold one node.
    """
    nodes = [node for node in network.nodes if node != AMBIENT]
    flows = HeatFlows(network, nodes, running, ambient_c)
    holding = list(neighbours)
    while holding:
        found = _rest(network, nodes, flows, holding)
        cool = [
            one for one, power_w in zip(holding, found[len(nodes) :], strict=True) if power_w < 0
        ]
        if not cool:
            return found[_place(network, nodes, sensor)]
        holding = [one for one in holding if one not in cool]
    return 0.0


def _place(network: ThermalNetwork, nodes: Sequence[str], sensor: str) -> int:
    node = network.sense[sensor].node
    if node is None:
        raise LookupError(sensor)
    return nodes.index(node)


def _rest(
    network: ThermalNetwork, nodes: Sequence[str], flows: HeatFlows, holding: Sequence[Neighbour]
) -> list[float]:
    """Return the steady state: each node above ambient, K, then each neighbour's power, W."""
    size, found = len(nodes), [0.0] * (len(nodes) + len(holding))
    heated = [nodes.index(network.heat[one.heater]) for one in holding]
    sensed = [_place(network, nodes, one.sensor) for one in holding]
    for _ in range(MOST_TRIES):
        conductances, constants = flows.about(found)
        rows = [
            [*row, *(-float(i == place) for place in heated)] for i, row in enumerate(conductances)
        ]
        rows += [[float(i == place) for i in range(size + len(holding))] for place in sensed]
        right = [*(-constant for constant in constants), *(one.above_ambient_k for one in holding)]
        before, found = found, [each.real for each in solve(rows, right)]
        if flows.linear or alike(before, found):
            break
    return found
