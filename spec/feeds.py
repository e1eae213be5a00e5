"""A machine while its scenario feeds filament, which takes heat away."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from heatwright.spec.outputs import always_running
from heatwright.spec.simulation import AMBIENT, Link, Simulation

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


def fastest_feed_mm_per_s(simulation: Simulation) -> float:
    """Return how fast the scenario feeds filament that takes heat, at most, mm/s; 0 for none."""
    filament = simulation.plant.filament
    if filament is None or filament.heat_j_per_k_mm == 0:
        return 0.0
    return max((event.extrude_mm_per_s or 0.0 for event in simulation.scenario), default=0.0)


def longest_feed_s(simulation: Simulation) -> float:
    """Return for how long the scenario feeds filament without a pause, at most, s."""
    longest_s, since_s = 0.0, math.inf
    for event in simulation.scenario:
        at_s = event.for_s if event.at_s is None else event.at_s
        longest_s = max(longest_s, (at_s or 0.0) - since_s)
        if event.extrude_mm_per_s is not None:
            since_s = min(since_s, at_s or 0.0) if event.extrude_mm_per_s else math.inf
    return longest_s


def fed(controller: Controller, simulation: Simulation) -> Simulation:
    """Return the machine at the fastest feed: it cools its node as a link to `ambient` does.

    The same one where nothing is fed. A fan that always runs would act on that link, too: it is
    made so much weaker.
    """
    plant, mm_per_s = simulation.plant, fastest_feed_mm_per_s(simulation)
    if plant.filament is None or mm_per_s == 0:
        return simulation
    between = (plant.filament.node, AMBIENT)
    resistance = 1 / (plant.filament.heat_j_per_k_mm * mm_per_s)
    for fan in always_running(controller.outputs):
        effect = plant.fans.get(fan)
        if effect is not None and set(effect.link) == set(between):
            resistance *= effect.factor
    link = Link.model_construct(between=between, resistance_k_per_w=resistance)
    links = (*plant.links, link)
    return simulation.model_copy(update={"plant": plant.model_copy(update={"links": links})})
