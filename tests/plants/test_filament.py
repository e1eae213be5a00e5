"""What fed filament takes from the machine."""

import math

import pytest
from test_thermal_network import ONE, plant

HEAT = 0.05
"""J/(K·mm): at 10 mm/s as much conductance as the link of 2 K/W."""
FILAMENT = {"node": "block", "heat": f"{HEAT} J/K/mm"}


def fed(machine, count, mm_per_s, on=1.0):
    for _ in range(count):
        machine.step({"heater": on, "fan": 0.0}, mm_per_s)
    return machine.temperatures_c[0]


def test_it_cools_by_its_heat_times_its_speed():
    """30 W over 1/2 + 0.05 · 10 W/K, with half the time constant."""
    machine = plant(ONE, power_w=30.0, filament=FILAMENT)
    assert fed(machine, 300, 10.0) == pytest.approx(20 + 30 * -math.expm1(-30 / 10), rel=1e-12)


def test_standing_still_it_takes_nothing():
    machine, without = plant(ONE, filament=FILAMENT), plant(ONE)
    assert fed(machine, 100, 0.0) == fed(without, 100, 0.0)


def test_at_ambient_there_is_nothing_to_take():
    assert fed(plant(ONE, filament=FILAMENT), 100, 10.0, on=0.0) == pytest.approx(20, rel=1e-12)


def test_a_machine_without_filament_does_not_feel_a_feed():
    assert fed(plant(ONE), 100, 10.0) == fed(plant(ONE), 100, 0.0)


def test_fast_and_slow_in_turn_is_the_mean_in_the_end():
    machine = plant(ONE, power_w=30.0, filament=FILAMENT, step_s=0.01)
    for _ in range(10_000):
        fed(machine, 1, 20.0)
        fed(machine, 1, 0.0)
    assert machine.temperatures_c[0] == pytest.approx(50.0, abs=30 * 0.01)
