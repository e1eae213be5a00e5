"""The plant against the laws of physics and analytic solutions."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import ThermalNetwork

EPSILON = np.finfo(float).eps

THREE = {
    "kind": "thermal_network",
    "nodes": {"element": "60 J/K", "air": "900 J/K", "walls": "4500 J/K"},
    "links": [
        {"between": ["element", "air"], "resistance": "0.35 K/W"},
        {"between": ["air", "walls"], "resistance": "0.173 K/W"},
        {"between": ["walls", "ambient"], "resistance": "0.130 K/W"},
    ],
    "heat": {"heater": "element"},
    "sense": {"air": {"node": "air", "lag": "8 s"}},
}

ONE = {
    "kind": "thermal_network",
    "nodes": {"block": "10 J/K"},
    "links": [{"between": ["block", "ambient"], "resistance": "2 K/W"}],
    "heat": {"heater": "block"},
    "sense": {"block": {"node": "block"}},
}


def network(base, **changes):
    return ThermalNetwork.model_validate({**base, **changes})


def plant(base, *, step_s=0.1, ambient_c=20.0, power_w=240.0, seed=0, **changes):
    powers_w = {"heater": power_w, "fan": 0.0}
    return Plant(network(base, **changes), powers_w, ambient_c=ambient_c, step_s=step_s, seed=seed)


def run(machine, count, on=1.0):
    for _ in range(count):
        machine.step({"heater": on, "fan": 0.0})
    return machine.temperatures_c


def test_one_node_follows_the_exponential():
    machine = plant(ONE, power_w=30.0)
    run(machine, 1000)  # 100 s, five time constants
    expected = 20 + 60 * -math.expm1(-100 / 20)
    assert machine.temperatures_c[0] == pytest.approx(expected, abs=1000 * EPSILON * expected)


def test_a_sensor_lags_as_a_first_order_system():
    sense = {"block": {"node": "block", "lag": "5 s"}}
    machine = plant(ONE, power_w=30.0, sense=sense)
    run(machine, 300)
    slow, fast, time_s = 20.0, 5.0, 30.0
    step = 1 - (slow * math.exp(-time_s / slow) - fast * math.exp(-time_s / fast)) / (slow - fast)
    assert machine.sensed_c()["block"] == pytest.approx(20 + 60 * step, abs=300 * EPSILON * 80)


def test_steady_state_is_ohms_law():
    machine = plant(THREE, step_s=10.0)
    run(machine, 3000)
    walls = 20 + 240 * 0.130
    air = walls + 240 * 0.173
    element = air + 240 * 0.35
    assert machine.temperatures_c == pytest.approx([element, air, walls], rel=1e-12)
    assert machine.sensed_c()["air"] == pytest.approx(air, rel=1e-12)


def test_without_heat_nothing_happens_at_ambient():
    machine = plant(THREE)
    run(machine, 1000, on=0.0)
    assert machine.temperatures_c == pytest.approx([20.0] * 3, abs=1000 * EPSILON * 20)


@pytest.mark.parametrize("step_s", [0.01, 0.25, 5.0])
def test_the_step_does_not_matter_while_the_heat_is_constant(step_s):
    reference, machine = plant(THREE, step_s=0.05), plant(THREE, step_s=step_s)
    for on in (1.0, 0.0, 0.37):
        run(reference, 2000, on)
        run(machine, round(100 / step_s), on)
    count = 6000 + 300 / step_s
    hottest = float(reference.temperatures_c.max())
    assert machine.temperatures_c == pytest.approx(
        reference.temperatures_c, abs=count * EPSILON * hottest
    )


def test_heat_is_neither_made_nor_lost():
    """What went in is stored or went to ambient: first law, to rounding.

    The loss needs the integral of the walls' temperature; here the walls' own balance gives it
    from an independent integration of the differential equations.
    """
    time_s, power_w, ambient_c = 600.0, 240.0, 20.0
    capacity = np.array([60.0, 900.0, 4500.0])
    machine = plant(THREE)
    run(machine, 6000)

    def slopes(_, state):
        element, air, walls, _ = state
        to_air, to_walls = (element - air) / 0.35, (air - walls) / 0.173
        loss = (walls - ambient_c) / 0.130
        return [
            (power_w - to_air) / 60,
            (to_air - to_walls) / 900,
            (to_walls - loss) / 4500,
            loss,
        ]

    start = [ambient_c] * 3 + [0.0]
    solution = solve_ivp(slopes, (0, time_s), start, method="DOP853", rtol=3e-14, atol=1e-12)
    stored_j = float((capacity * (machine.temperatures_c - ambient_c)).sum())
    lost_j = float(solution.y[3, -1])
    assert stored_j + lost_j == pytest.approx(power_w * time_s, rel=1e-11)


def test_a_closed_system_keeps_its_energy():
    inside = [link for link in THREE["links"] if "ambient" not in link["between"]]
    machine = plant(THREE, links=inside)
    run(machine, 1000)
    capacity = np.array([60.0, 900.0, 4500.0])
    stored_j = float((capacity * (machine.temperatures_c - 20.0)).sum())
    assert stored_j == pytest.approx(240.0 * 100.0, rel=1e-11)


@pytest.mark.parametrize("delay_s", [0.1, 0.25, 3.0])
def test_dead_time_shifts_the_response(delay_s):
    late = {"block": {"node": "block", "delay": f"{delay_s} s"}}
    prompt, delayed = plant(ONE, power_w=30.0), plant(ONE, power_w=30.0, sense=late)
    count, shift = 500, delay_s / 0.1
    history = [prompt.sensed_c()["block"]]
    for _ in range(count):
        run(prompt, 1)
        run(delayed, 1)
        history.append(prompt.sensed_c()["block"])
    expected = np.interp(count - shift, range(count + 1), history)
    assert delayed.sensed_c()["block"] == pytest.approx(float(expected), abs=1e-12)


def test_nothing_is_felt_before_the_dead_time():
    machine = plant(ONE, sense={"block": {"node": "block", "delay": "1 s"}})
    run(machine, 10)
    assert machine.sensed_c()["block"] == 20.0
    run(machine, 1)
    assert machine.sensed_c()["block"] > 20.0


FAN = {"fan": {"link": ["ambient", "block"], "factor": 3}}


@pytest.mark.parametrize(("fraction", "conductance"), [(0.0, 0.5), (0.5, 1.0), (1.0, 1.5)])
def test_a_fan_multiplies_the_conductance_of_its_link(fraction, conductance):
    machine = plant(ONE, power_w=30.0, fans=FAN, step_s=10.0)
    for _ in range(100):
        machine.step({"heater": 1.0, "fan": fraction})
    assert machine.temperatures_c[0] == pytest.approx(20 + 30 / conductance, rel=1e-12)


def test_noise_is_seeded_and_has_its_width():
    noisy = {"block": {"node": "block", "noise": "0.1 K"}}

    def felt(seed):
        machine = plant(ONE, sense=noisy, seed=seed)
        values = []
        for _ in range(10_000):
            run(machine, 1, on=0.0)
            values.append(machine.sensed_c()["block"])
        return np.array(values)

    first = felt(1)
    assert np.array_equal(first, felt(1))
    assert not np.array_equal(first, felt(2))
    # five standard errors of the mean and of the deviation
    assert first.mean() == pytest.approx(20.0, abs=5 * 0.1 / math.sqrt(10_000))
    assert first.std() == pytest.approx(0.1, abs=5 * 0.1 / math.sqrt(20_000))


def test_starts_where_it_is_told():
    machine = plant(THREE, initial="60 °C")
    assert machine.temperatures_c.tolist() == [60.0] * 3
    assert machine.sensed_c() == {"air": 60.0}
