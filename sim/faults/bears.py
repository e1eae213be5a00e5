"""How hot each node of a machine may become, and what that is where the specification is silent."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from heatwright.sim.plants import Temperatures, full_power, nodes_of, plant_of, profile_c
from heatwright.spec import Controller

LONGEST_S = 24 * 3600.0
SPARE = 0.1
"""Of the rise above the surroundings: machines differ."""
LEVEL_K = 0.001
"""So little in a minute is no rise any more."""


@lru_cache(maxsize=8)
def bears_c(controller: Controller) -> Mapping[str, float]:
    """Return what every node bears, °C: `bears` of the plant, or what full power makes of it.

    A machine must bear what its own protection lets happen: full power from cold until the
    loop's sensor reads `protection.maximum`, and the heat that spreads after that; or a long time
    just below that maximum. On top comes a tenth of the rise. A loop counts for the nodes that are
    nearer to it than to others, and for those between loops.

    Raises ValueError when there is no machine.
    """
    simulation = controller.simulation
    if simulation is None:
        raise ValueError("Faults need a machine: the specification has no `simulation`.")
    plant, ambient_c = simulation.plant, simulation.ambient_c
    own = nodes_of(controller, plant)
    hottest = np.full(len(plant.nodes), ambient_c)
    for name in controller.loops:
        peaks = _peaks_c(controller, name, ambient_c)
        others = {node for other, nodes in own.items() if other != name for node in nodes}
        mine = np.array([node not in others for node in plant.nodes])
        hottest = np.where(mine, np.maximum(hottest, peaks), hottest)
        maximum_c = controller.loops[name].protection.maximum_c
        held = profile_c(controller, plant, name, maximum_c, ambient_c=ambient_c)
        hottest = np.maximum(hottest, [held.get(node, ambient_c) for node in plant.nodes])
    derived = ambient_c + (1 + SPARE) * (hottest - ambient_c)
    return dict(zip(plant.nodes, derived.tolist(), strict=True)) | dict(plant.bears_c)


def _peaks_c(controller: Controller, name: str, ambient_c: float) -> Temperatures:
    """Heat at full power until the sensor reads the maximum, or until nothing rises any more."""
    assert controller.simulation is not None  # noqa: S101 - looked at by the only caller
    loop = controller.loops[name]
    network = controller.simulation.plant.model_copy(update={"initial_c": ambient_c})
    plant = plant_of(controller, network, ambient_c=ambient_c, step_s=loop.period_s)
    peaks, heat = plant.temperatures_c.copy(), 1.0
    minute = max(1, round(60.0 / loop.period_s))
    before = peaks.copy()
    for row in range(1, round(LONGEST_S / loop.period_s)):
        plant.step(full_power(controller, name, heat))
        np.maximum(peaks, plant.temperatures_c, out=peaks)
        if heat and plant.sensed_c()[loop.sensor] >= loop.protection.maximum_c:
            heat = 0.0
        if row % minute == 0:
            if np.all(peaks - before < LEVEL_K):
                break
            before = peaks.copy()
    return peaks
