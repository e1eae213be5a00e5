"""How hot each node of a machine may become; derived where the spec has no limit for it."""

import math
from collections.abc import Mapping

import numpy as np

from heatwright.sim.faults.bounds import reading_s
from heatwright.sim.plants import Temperatures, full_power, nodes_of, plant_of, profile_c
from heatwright.spec import Controller, ThermalNetwork

LONGEST_S = 24 * 3600.0
SPARE = 0.1
"""Margin, as a share of the rise above ambient, because machines differ."""
WARM_DAY_C = 35.0
"""A workshop in summer."""
REST_K = 1.0
"""A machine in its steady state is at least this far from its limits, plus one sensor step."""
SIGMAS = 6.0
"""Noise is at most this many times its standard deviation."""
LEVEL_K = 0.001
"""A smaller rise in a minute counts as none."""


_KNOWN: dict[str, Mapping[str, float]] = {}
"""Results by the `repr` of their inputs: a plant that was changed for a trial has no hash."""


def bears_c(controller: Controller, plant: ThermalNetwork) -> Mapping[str, float]:
    """Return each node's limit, °C: `bears` of the plant, or what full power heats the node to.

    A machine must withstand what its own protection allows: full power from cold until the
    loop's sensor reads `protection.maximum`, then until that rule must have switched it off,
    then the heat that spreads after that; or a long time just below that maximum. A tenth of the
    rise is added. Each loop heats the nodes that are nearer to it than to other loops, and those
    between loops.

    The ambient is that of the spec, or that of a warm day: whichever gives more.
    """
    key = repr((controller, plant))
    if key not in _KNOWN:
        _KNOWN[key] = _derived_c(controller, plant) | dict(plant.bears_c)
    return _KNOWN[key]


def _derived_c(controller: Controller, plant: ThermalNetwork) -> dict[str, float]:
    simulation = controller.simulation
    rooms_c = {room_c(controller, WARM_DAY_C), simulation.ambient_c if simulation else WARM_DAY_C}
    each_c = [_derived_at_c(controller, plant, ambient_c) for ambient_c in rooms_c]
    return {node: max(found[node] for found in each_c) for node in plant.nodes}


def room_c(controller: Controller, wished_c: float) -> float:
    """Return the ambient nearest to a wished one at which a steady machine trips no rule, °C."""
    least_c = max(coldest_c(controller, name) for name in controller.loops)
    most_c = min(most_c for _, most_c in hottest_c(controller))
    return max(least_c, min(most_c, wished_c))


def hottest_c(controller: Controller, without: str = "") -> list[tuple[str, float]]:
    """List monitors' and loops' sensors, with the highest steady °C at which no rule trips.

    without -- the name of a loop that is left out.
    """
    limits_c = [(each.sensor, each.limit_c) for each in controller.monitors.values()]
    limits_c += [
        (each.sensor, each.protection.maximum_c)
        for name, each in controller.loops.items()
        if name != without
    ]
    return [(sensor, limit_c - _away_k(controller, sensor)) for sensor, limit_c in limits_c]


def coldest_c(controller: Controller, name: str) -> float:
    """Return the lowest temperature at which a loop in the steady state does not trip, °C."""
    loop = controller.loops[name]
    return loop.protection.minimum_c + _away_k(controller, loop.sensor)


def _away_k(controller: Controller, sensor: str) -> float:
    """Return the least distance of a steady machine from its limits, K: sensor step and noise."""
    sense = controller.simulation.plant.sense[sensor] if controller.simulation else None
    noise_k = SIGMAS * sense.noise_k if sense else 0.0
    return REST_K + controller.thermometers[sensor].step_k + noise_k


def _derived_at_c(
    controller: Controller, plant: ThermalNetwork, ambient_c: float
) -> dict[str, float]:
    own = nodes_of(controller, plant)
    hottest = np.full(len(plant.nodes), ambient_c)
    for name in controller.loops:
        peaks = _peaks_c(controller, plant, name, ambient_c)
        mine = np.array([node in own[name] for node in plant.nodes])
        hottest = np.where(mine, np.maximum(hottest, peaks), hottest)
        maximum_c = controller.loops[name].protection.maximum_c
        held = profile_c(controller, plant, name, maximum_c, ambient_c=ambient_c)
        hottest = np.maximum(hottest, [held.get(node, ambient_c) for node in plant.nodes])
    # A node without any heat is within rounding errors of the ambient temperature.
    derived = ambient_c + np.maximum((1 + SPARE) * (hottest - ambient_c), LEVEL_K)
    return dict(zip(plant.nodes, derived.tolist(), strict=True))


def _peaks_c(
    controller: Controller, network: ThermalNetwork, name: str, ambient_c: float
) -> Temperatures:
    """Return each node's highest temperature if full power heats until `over_temperature` trips."""
    loop = controller.loops[name]
    cold = network.model_copy(update={"initial_c": ambient_c})
    plant = plant_of(controller, cold, ambient_c=ambient_c, step_s=loop.period_s)
    peaks, heated = plant.temperatures_c.copy(), full_power(controller, name, 1.0)
    left = math.ceil(loop.periods_in(reading_s(loop)))
    minute = max(1, round(loop.periods_in(60.0)))
    before = peaks.copy()
    for row in range(1, round(loop.periods_in(LONGEST_S))):
        plant.step(heated)
        np.maximum(peaks, plant.temperatures_c, out=peaks)
        if plant.sensed_c()[loop.sensor] >= loop.protection.maximum_c:
            left = max(0, left - 1)
            heated = full_power(controller, name, float(left > 0))
        if row % minute == 0:
            if np.all(peaks - before < LEVEL_K):
                break
            before = peaks.copy()
    return peaks
