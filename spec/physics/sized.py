"""The calculation by which a machine is sized: heat through walls, and a wire in moving air.

Walls are thermal resistances in a row: film inside, layers d/(λ·A), and outside film and radiation
side by side. The film of a wind is that of Jürges' measurements on smooth plates, as McAdams gives
it; a wire's is that of Churchill and Bernstein for a cylinder across a flow (1977), with the air of
the US Standard Atmosphere of 1976 between wire and air, at sea level.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from heatwright.spec.base import ABSOLUTE_ZERO_C
from heatwright.spec.physics.heat_flows import STEFAN_BOLTZMANN
from heatwright.spec.physics.sizing import Wall, Wire

FILM_W_PER_M2K = 8.7
"""Heat transfer coefficient of a wall's surface in still air."""

FOOT_M = 0.3048
BTU_W_PER_M2K = 5.678263
"""Jürges' law is given in feet and in BTU/(h·ft²·°F)."""
FRESH_FT_PER_S = 16.0
"""Wind speed above which the film coefficient grows with the speed's power of 0.78."""

AIR_J_PER_KG_K = 1007.0
AIR_GAS_J_PER_KG_K = 287.05
SEA_LEVEL_PA = 101_325.0

BISECTIONS = 60
HOTTEST_K = 1e5


class SizedWall(NamedTuple):
    """One wall between two given temperatures; resistances in K/W."""

    inside_k_per_w: float
    layers_k_per_w: float
    outside_k_per_w: float
    """Resistance of film and radiation side by side."""
    loss_w: float
    surface_c: float
    """Temperature of the outer surface, °C."""


class SizedWire(NamedTuple):
    """A wire that gives the heater's power at its voltage, with the surface load of the spec."""

    diameter_mm: float
    length_m: float
    current_a: float
    resistance_ohm: float
    air_c: float
    temperature_c: float
    load_as_measured_w_per_cm2: float | None
    """Surface load at which such a wire has the measured temperature; None if none was measured."""


def wind_film_w_per_m2k(wind_m_per_s: float) -> float:
    """Return the heat transfer coefficient of a smooth wall with a wind along it, W/m²K."""
    speed = wind_m_per_s / FOOT_M
    slow = speed < FRESH_FT_PER_S
    return BTU_W_PER_M2K * (0.99 + 0.21 * speed if slow else 0.5 * speed**0.78)


def sized_wall(wall: Wall, inside_c: float, outside_c: float) -> SizedWall:
    """Find the heat through a wall, and the temperature of the surface that gives it off."""
    inside = 1 / (wall.inside_w_per_m2k * wall.area_m2)
    layers = sum(
        each.thickness_mm / 1000 / (each.conductivity_w_per_mk * wall.area_m2)
        for each in wall.layers
    )
    film = wall.outside_w_per_m2k or FILM_W_PER_M2K
    if wall.wind_m_per_s is not None:
        film = wind_film_w_per_m2k(wall.wind_m_per_s)

    def leaves_w(surface_c: float) -> float:
        radiated = wall.emissivity * _black_w_per_m2(surface_c, outside_c)
        return wall.area_m2 * (film * (surface_c - outside_c) + radiated)

    surface_c = _root(
        lambda surface_c: leaves_w(surface_c) - (inside_c - surface_c) / (inside + layers),
        outside_c,
        inside_c,
    )
    loss_w = (inside_c - surface_c) / (inside + layers)
    return SizedWall(inside, layers, (surface_c - outside_c) / loss_w, loss_w, surface_c)


def sized_wire(wire: Wire, power_w: float, voltage_v: float, air_c: float) -> SizedWire:
    """Find a wire's diameter and length from its surface load, and its temperature."""
    load = wire.surface_load_w_per_cm2 * 1e4
    diameter_m = _diameter_m(wire, power_w, voltage_v, load)
    as_measured = None
    if wire.measured_c is not None and wire.measured_c > air_c:
        measured_c = wire.measured_c

        def missing_k(exponent: float) -> float:
            tried = math.exp(exponent)
            diameter_m = _diameter_m(wire, power_w, voltage_v, tried)
            return _wire_c(wire, diameter_m, tried, air_c) - measured_c

        as_measured = math.exp(_root(missing_k, math.log(1.0), math.log(1e8))) / 1e4
    return SizedWire(
        diameter_mm=1000 * diameter_m,
        length_m=power_w / (math.pi * diameter_m * load),
        current_a=power_w / voltage_v,
        resistance_ohm=voltage_v**2 / power_w,
        air_c=air_c,
        temperature_c=_wire_c(wire, diameter_m, load, air_c),
        load_as_measured_w_per_cm2=as_measured,
    )


def _diameter_m(wire: Wire, power_w: float, voltage_v: float, load_w_per_m2: float) -> float:
    """Solve P = β·π·d·L and U²/P = ρ·L/(π·d²/4) for the diameter d, m."""
    resistivity_ohm_m = wire.resistivity_ohm_mm2_per_m * 1e-6
    cube = 4 * resistivity_ohm_m * (power_w / (math.pi * voltage_v)) ** 2 / load_w_per_m2
    return float(cube ** (1 / 3))


def _wire_c(wire: Wire, diameter_m: float, load_w_per_m2: float, air_c: float) -> float:
    """Return the temperature at which a wire gives off its surface load, °C."""

    def leaves(wire_c: float) -> float:
        film = cross_flow_film_w_per_m2k(
            diameter_m, wire.air_speed_m_per_s, (wire_c + air_c) / 2
        )  # fmt: skip
        radiated = wire.emissivity * _black_w_per_m2(wire_c, air_c)
        return film * (wire_c - air_c) + radiated - load_w_per_m2

    return _root(leaves, air_c, air_c + HOTTEST_K)


def cross_flow_film_w_per_m2k(diameter_m: float, speed_m_per_s: float, film_c: float) -> float:
    """Return the heat transfer coefficient of a cylinder with air flowing across it, W/m²K."""
    kelvin = film_c - ABSOLUTE_ZERO_C
    viscosity_pa_s = 1.458e-6 * kelvin**1.5 / (kelvin + 110.4)
    conductivity = 2.64638e-3 * kelvin**1.5 / (kelvin + 245.4 * 10 ** (-12 / kelvin))
    density = SEA_LEVEL_PA / (AIR_GAS_J_PER_KG_K * kelvin)
    prandtl = viscosity_pa_s * AIR_J_PER_KG_K / conductivity
    reynolds = density * speed_m_per_s * diameter_m / viscosity_pa_s
    laminar = 0.62 * math.sqrt(reynolds) * prandtl ** (1 / 3)
    laminar /= (1 + (0.4 / prandtl) ** (2 / 3)) ** 0.25
    nusselt = 0.3 + laminar * (1 + (reynolds / 282_000) ** 0.625) ** 0.8
    return float(nusselt * conductivity / diameter_m)


def _black_w_per_m2(surface_c: float, around_c: float) -> float:
    hot_k, cold_k = surface_c - ABSOLUTE_ZERO_C, around_c - ABSOLUTE_ZERO_C
    return float(STEFAN_BOLTZMANN * (hot_k**4 - cold_k**4))


def _root(rising: Callable[[float], float], low: float, high: float) -> float:
    """Return where a rising function is 0, or the nearest end of the interval."""
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if rising(middle) > 0 else (middle, high)
    return (low + high) / 2
