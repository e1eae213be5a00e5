"""What surfaces radiate, against Stefan and Boltzmann's law and exact solutions."""

import math
from itertools import pairwise

import pytest
from scipy.integrate import solve_ivp
from test_thermal_network import THREE, plant, run

SIGMA = 5.670374419e-8
ZERO_K_C = -273.15
AREA_M2, EMISSIVITY = 0.02, 0.9
FACTOR = SIGMA * AREA_M2 * EMISSIVITY
RADIATION = {"area": f"{AREA_M2} m²", "emissivity": EMISSIVITY}
ALONE = {
    "kind": "thermal_network",
    "nodes": {"block": "50 J/K"},
    "links": [],
    "radiation": [{"between": ["block", "ambient"], **RADIATION}],
    "heat": {"heater": "block"},
    "sense": {"block": {"node": "block"}},
}
HALF_A_CELL = 0.01
"""The conductance of the grid is off by a hundredth at most."""


def test_a_block_in_empty_space_cools_by_the_inverse_cube():
    """C·dT/dt = −f·T⁴: T^−3 grows by 3·f·t/C.

    A step with the conductance of its beginning goes to exp(−x), x = f·T³·Δt/C, of where it was,
    and should to (1 + 3·x)^(−1/3): that is 1.5·x² too low, and the sum of all x is ln(T₀/T).
    """
    step_s, start_k, heat = 0.1, 1200.0, 50.0
    machine = plant(ALONE, step_s=step_s, ambient_c=ZERO_K_C, initial=f"{start_k + ZERO_K_C} °C")
    for seconds in range(1, 200):
        found_k = run(machine, 10, on=0.0)[0] - ZERO_K_C
        exact_k = (start_k**-3 + 3 * FACTOR * seconds / heat) ** (-1 / 3)
        largest = FACTOR * start_k**3 / heat * step_s
        off = (1.5 + HALF_A_CELL) * largest * math.log(start_k / exact_k)
        assert found_k == pytest.approx(exact_k, rel=off)


def test_a_heated_block_ends_where_it_radiates_what_it_is_given():
    machine = plant(ALONE, power_w=240.0, ambient_c=20.0)
    found_k = run(machine, 20_000, on=1.0)[0] - ZERO_K_C
    assert FACTOR * (found_k**4 - (20 - ZERO_K_C) ** 4) == pytest.approx(240.0, rel=1e-9)


def test_at_the_temperature_of_its_surroundings_nothing_is_radiated():
    assert run(plant(ALONE), 1000, on=0.0)[0] == pytest.approx(20.0, abs=1e-9)


def test_what_one_node_loses_another_gains():
    radiation = [{"between": ["walls", "element"], **RADIATION}]
    machine = plant(THREE, links=[], radiation=radiation, initial="500 °C")
    run(machine, 10, on=1.0)
    element_c, _, walls_c = run(machine, 100_000, on=0.0)
    assert element_c == pytest.approx(walls_c, abs=1e-6)
    assert 60 * element_c + 4500 * walls_c == pytest.approx(4560 * 500 + 240.0, rel=1e-9)


def test_a_surface_as_large_as_may_be_stays_calm():
    """Far quicker than a step: each goes to ambient, but for the cell of the grid."""
    huge = [{"between": ["block", "ambient"], "area": "1000 m²", "emissivity": 1}]
    machine = plant(ALONE, radiation=huge, initial="1000 °C", step_s=0.2)
    away_k = 980.0
    for _ in range(5):
        left_k = abs(run(machine, 1, on=0.0)[0] - 20.0)
        assert left_k <= HALF_A_CELL * away_k
        away_k = left_k


def test_with_links_it_follows_a_fine_integration():
    radiation = [
        {"between": ["element", "walls"], **RADIATION},
        {"between": ["walls", "ambient"], **RADIATION},
    ]
    machine = plant(THREE, radiation=radiation, power_w=2000.0)

    def slopes(_, t):
        element, air, walls = t
        kelvin = [each - ZERO_K_C for each in (element, walls, 20.0)]
        inner, outer = (FACTOR * (hot**4 - cold**4) for hot, cold in pairwise(kelvin))
        first, second, third = (element - air) / 0.35, (air - walls) / 0.173, (walls - 20) / 0.130
        return [
            (2000 - first - inner) / 60,
            (first - second) / 900,
            (second - third + inner - outer) / 4500,
        ]

    fine = solve_ivp(slopes, (0, 3000), [20.0] * 3, method="LSODA", rtol=1e-10, atol=1e-9)
    found = run(machine, 30_000, on=1.0)
    assert found == pytest.approx(fine.y[:, -1], rel=1e-5)
