"""A machine while its scenario feeds filament, which takes heat away."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from heatwright.spec.outputs import always_running
from heatwright.spec.simulation import (
    AMBIENT,
    LEAST_VERIFIED_S,
    Event,
    Link,
    Simulation,
    ThermalNetwork,
)

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


def lasting_feed_mm_per_s(simulation: Simulation, least_s: float) -> float:
    """Return the highest speed that the scenario's feed keeps for longer than `least_s`, mm/s.

    A faster feed counts as one at a lower speed, too. `verify` extends a short scenario, and its
    last feed. The speed is 0 without a feed, or if filament takes no heat.
    """
    filament = simulation.plant.filament
    if filament is None or filament.heat_j_per_k_mm == 0:
        return 0.0
    stretches = [*_stretches(simulation)]
    speeds = sorted({speed for speed, _ in stretches}, reverse=True)
    return next((speed for speed in speeds if _longest_s(stretches, speed) > least_s), 0.0)


def _stretches(simulation: Simulation) -> Iterator[tuple[float, float]]:
    """Yield the speeds of the feed, mm/s, and for how long each is kept, s."""
    since_s = speed = 0.0
    for event in sorted(simulation.scenario, key=_time_s):
        if event.extrude_mm_per_s is not None or event.for_s is not None:
            yield speed, _time_s(event) - since_s
            since_s, speed = _time_s(event), event.extrude_mm_per_s or 0.0


def _time_s(event: Event) -> float:
    return event.at_s or 0.0 if event.for_s is None else max(event.for_s, LEAST_VERIFIED_S)


def _longest_s(stretches: Iterable[tuple[float, float]], least_mm_per_s: float) -> float:
    longest_s = lasts_s = 0.0
    for speed, length_s in stretches:
        lasts_s = lasts_s + length_s if speed >= least_mm_per_s else 0.0
        longest_s = max(longest_s, lasts_s)
    return longest_s


def fed(controller: Controller, simulation: Simulation, mm_per_s: float) -> Simulation:
    """Return the machine during a feed, which cools a node as a link to `ambient` does.

    Without a feed the machine is unchanged. A fan that always runs would act on the link, too, so
    the link is made weaker by the fan's factor.
    """
    plant, weaker = simulation.plant, 1.0
    if plant.filament is None:
        return simulation
    for fan in always_running(controller.outputs):
        effect = plant.fans.get(fan)
        if effect is not None and set(effect.link) == {plant.filament.node, AMBIENT}:
            weaker *= effect.factor
    return simulation.model_copy(update={"plant": fed_plant(plant, mm_per_s, weaker)})


def fed_plant(plant: ThermalNetwork, mm_per_s: float, weaker: float = 1.0) -> ThermalNetwork:
    """Return the plant with one more link, for the heat that the fed material takes.

    weaker -- factor on the link's resistance.
    """
    filament = plant.filament
    if filament is None or filament.heat_j_per_k_mm * mm_per_s == 0:
        return plant
    resistance = weaker / (filament.heat_j_per_k_mm * mm_per_s)
    link = Link.model_construct(between=(filament.node, AMBIENT), resistance_k_per_w=resistance)
    return plant.model_copy(update={"links": (*plant.links, link)})
