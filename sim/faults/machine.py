"""What a healthy machine can do: how hot it gets, how fast, and up to which setpoint."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.sim.faults.world import Site
from heatwright.sim.plants import plant_of
from heatwright.spec import ThermalNetwork

FOREVER_S = 1e7
"""Longer than any machine takes to settle: four months."""
COURSE_STEP_S = 1.0
LONGEST_S = 24 * 3600.0


def steady_c(site: Site, share: float, *, ambient_c: float) -> float:
    """Return where the loop's sensor settles with its heater at a share (0..1) of its power, °C."""
    plant = plant_of(site.controller, site.network, ambient_c=ambient_c, step_s=FOREVER_S)
    plant.step(_powered(site, share))
    return plant.sensed_c()[site.loop.sensor]


def share_for(site: Site, hold_c: float, *, ambient_c: float) -> float:
    """Return the share of the heater's power that would hold a temperature, °C; it may exceed 1."""
    return (hold_c - ambient_c) / (steady_c(site, 1.0, ambient_c=ambient_c) - ambient_c)


def rise_k(site: Site, after_s: float) -> float:
    """Return how far full power raises the loop's sensor in a time, from rest, K."""
    for time_s, risen_k in course(site, site.network, ambient_c=0.0):
        if time_s >= after_s:
            return risen_k
    return 0.0


def course(
    site: Site, network: ThermalNetwork, *, ambient_c: float
) -> Iterator[tuple[float, float]]:
    """Yield time (s) and temperature (°C) at full power, from rest."""
    at_rest = network.model_copy(update={"initial_c": ambient_c})
    plant = plant_of(site.controller, at_rest, ambient_c=ambient_c, step_s=COURSE_STEP_S)
    asked = _powered(site, 1.0)
    for row in range(round(LONGEST_S / COURSE_STEP_S)):
        yield row * COURSE_STEP_S, plant.sensed_c()[site.loop.sensor]
        plant.step(asked)


def usable_c(site: Site, network: ThermalNetwork, *, ambient_c: float) -> float:
    """Return the highest setpoint this machine can be asked for without cause for a fault, °C.

    Full power has to bring `heating.rise`, and one step of the sensor more, within
    `heating.within`; a machine that is too weak for that near its setpoint breaks the rule
    `heating_failed` with good reason. Not above the highest setpoint.
    """
    loop = site.loop
    rule = loop.protection.heating
    highest_c = loop.setpoint.maximum_c
    if rule is None:
        return min(highest_c, steady_c(site, 1.0, ambient_c=ambient_c))
    needed_k = rule.rise_k + sensor_step_k(site)
    since_s, from_c = 0.0, ambient_c
    for time_s, sensed_c in course(site, network, ambient_c=ambient_c):
        if sensed_c >= from_c + needed_k:
            since_s, from_c = time_s, sensed_c
        if time_s - since_s > rule.within_s or from_c >= highest_c:
            break
    return min(highest_c, from_c)


def sensor_step_k(site: Site) -> float:
    """Return one step of the loop's sensor, K."""
    return float(site.controller.sensors[site.loop.sensor].step_k)


def _powered(site: Site, share: float) -> dict[str, float]:
    """Everything on but other loops' heaters."""
    others = {loop.heater for loop in site.controller.loops.values()} - {site.loop.heater}
    asked = dict.fromkeys(site.controller.outputs, 1.0) | dict.fromkeys(others, 0.0)
    return asked | {site.loop.heater: share}
