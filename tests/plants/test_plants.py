"""The plant against the laws of physics, and in C beside its processor."""

import math
from collections.abc import Callable
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from rig.firmware import EXAMPLE_NAMES, changed, example, spec_of, whole
from scipy.integrate import solve_ivp

from heatwright import spec
from heatwright.sim.bench import ReferenceDevice, bench, step_of
from heatwright.sim.coupling import sums_noise
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.site import Site
from heatwright.sim.faults.world import Weather, World
from heatwright.sim.interfaces.modbus_rtu import ModbusMaster
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.plants import plant_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.sim.trace import Trace
from heatwright.spec import Event, ThermalNetwork, kinds

THREE = {
    "kind": "thermal_network", "heat": {"heater": "element"},
    "nodes": {"element": "60 J/K", "air": "900 J/K", "walls": "4500 J/K"},
    "links": [
        {"between": ["element", "air"], "resistance": "0.35 K/W"},
        {"between": ["air", "walls"], "resistance": "0.173 K/W"},
        {"between": ["walls", "ambient"], "resistance": "0.130 K/W"},
    ],
    "sense": {"air": {"node": "air", "lag": "8 s"}},
}  # fmt: skip
ONE = {
    "kind": "thermal_network", "nodes": {"block": "10 J/K"}, "heat": {"heater": "block"},
    "links": [{"between": ["block", "ambient"], "resistance": "2 K/W"}],
    "sense": {"block": {"node": "block"}},
}  # fmt: skip
AMBIENT, AMBIENT_C, POWER_W = "ambient", 20.0, 240.0


def plant(
    base: Any, *, step_s: float = 0.1, ambient_c: float = AMBIENT_C, power_w: float = POWER_W,
    seed: int = 0, **changes: Any,
) -> Plant:  # fmt: skip
    network = ThermalNetwork.model_validate({**base, **changes})
    powers_w = {"heater": power_w, "fan": 0.0}
    return Plant(network, powers_w, ambient_c=ambient_c, step_s=step_s, seed=seed)


def run(
    machine: Plant, count: int, on: float = 1.0, fan: float = 0.0, mm_per_s: float = 0.0
) -> NDArray[np.float64]:
    for _ in range(count):
        machine.step({"heater": on, "fan": fan}, mm_per_s)
    return machine.temperatures_c


SHARES = st.sampled_from([0.0, 0.37, 1.0])
PHASES = st.lists(
    st.tuples(st.integers(1, 40), SHARES, SHARES, st.sampled_from([0.0, 2.5, 10.0])),
    min_size=1, max_size=4,
)  # fmt: skip
"""Seconds, and over them the shares of heater and fan, and the filament's speed in mm/s."""


@st.composite
def networks(draw: st.DrawFn) -> tuple[dict[str, Any], Callable[..., Any]]:
    """Up to three nodes in a row, of which the last is joined to ambient or to nothing. And the
    physics of it: C · dT/dt of a node is the heat that flows in, τ · dy/dt = T − y of a sensor that
    lags."""
    capacities = draw(st.lists(st.integers(10, 5000), min_size=1, max_size=3))
    count = len(capacities)
    names = [*(f"node{number}" for number in range(count)), AMBIENT]
    joined = range(count - draw(st.integers(0, min(1, count - 1))))
    resistances = [draw(st.floats(0.05, 5)) for _ in joined]
    heated, fed, sensed = (draw(st.integers(0, count - 1)) for _ in range(3))
    blown, factor = draw(st.sampled_from(joined)), draw(st.floats(1, 5))
    heat, lag_s = draw(st.floats(0.01, 1)), draw(st.integers(1, 20))
    ends = [names[number : number + 2] for number in joined]
    network = {
        "nodes": {name: f"{each} J/K" for name, each in zip(names, capacities, strict=False)},
        "links": [{"between": pair, "resistance": f"{value} K/W"}
                  for pair, value in zip(ends, resistances, strict=True)],
        "kind": "thermal_network", "heat": {"heater": names[heated]},
        "fans": {"fan": {"link": ends[blown][::-1], "factor": factor}},
        "filament": {"node": names[fed], "heat": f"{heat} J/K/mm"},
        "sense": {"tip": {"node": names[sensed], "lag": f"{lag_s} s"}},
        "initial": f"{draw(st.sampled_from([20, 300]))} °C",
    }  # fmt: skip

    def slopes(_: float, state: Any, on: float, fan: float, mm_per_s: float) -> list[float]:
        *nodes_c, tip_c = state
        levels_c, flows_w = [*nodes_c, AMBIENT_C], [0.0] * (count + 1)
        for number, resistance in enumerate(resistances):
            gain = 1 + (factor - 1) * fan if number == blown else 1.0
            flow_w = (levels_c[number + 1] - levels_c[number]) / resistance * gain
            flows_w[number] += flow_w
            flows_w[number + 1] -= flow_w
        flows_w[heated] += POWER_W * on
        flows_w[fed] -= heat * mm_per_s * (levels_c[fed] - AMBIENT_C)
        found = [flow_w / each for flow_w, each in zip(flows_w, capacities, strict=False)]
        return [*found, (levels_c[sensed] - tip_c) / lag_s]

    return network, slopes


@given(networks(), PHASES, st.sampled_from([0.05, 0.25, 1.0]))
@settings(max_examples=60)
def test_any_network_follows_a_fine_integration(drawn: Any, phases: Any, step_s: float) -> None:
    """Whatever is heated, blown at and fed, in steps of any length: heat is constant over them."""
    network, slopes = drawn
    machine = plant(network, step_s=step_s)
    state = [float(network["initial"].split()[0])] * (len(network["nodes"]) + 1)
    for seconds, *said in phases:
        fine = solve_ivp(slopes, (0, seconds), state, "LSODA", rtol=1e-11, atol=1e-9, args=said)
        state = fine.y[:, -1]
        run(machine, round(seconds / step_s), *said)
        felt_c = machine.sensed_c()["tip"]
        assert [*machine.temperatures_c, felt_c] == pytest.approx(state, rel=1e-7)


@pytest.mark.parametrize("delay_s", [0.1, 0.25, 3.0])
def test_dead_time_shifts_the_response(delay_s: float) -> None:
    late = {"block": {"node": "block", "delay": f"{delay_s} s"}}
    prompt, delayed = plant(ONE, power_w=30.0), plant(ONE, power_w=30.0, sense=late)
    history = [20.0]
    for number in range(1, 500):
        for machine in (prompt, delayed):
            run(machine, 1)
        history.append(prompt.sensed_c()["block"])
        expected = np.interp(number - delay_s / 0.1, range(number + 1), history)
        assert delayed.sensed_c()["block"] == pytest.approx(float(expected), abs=1e-12)


def test_noise_is_seeded_and_has_its_width() -> None:
    noisy = {"block": {"node": "block", "noise": "0.1 K"}}

    def felt(seed: int) -> NDArray[np.float64]:
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


@pytest.mark.parametrize("kind", kinds(spec.Plant))
def test_every_plant_of_the_language_has_its_module(kind: str) -> None:
    assert import_module(f"heatwright.sim.plants.{kind}").Plant


SIGMA = 5.670374419e-8
ZERO_K_C = -273.15
AREA_M2, EMISSIVITY = 0.02, 0.9
FACTOR = SIGMA * AREA_M2 * EMISSIVITY
RADIATION = {"area": f"{AREA_M2} m²", "emissivity": EMISSIVITY}
GLOWS = {"radiation": [{"between": ["block", "ambient"], **RADIATION}]}
ALONE = ONE | {"nodes": {"block": "50 J/K"}, "links": []} | GLOWS
HALF_A_CELL = 0.01  # the conductance of the grid is off by a hundredth at most


def test_a_block_in_empty_space_cools_by_the_inverse_cube():
    """C·dT/dt = −f·T⁴: T^−3 grows by 3·f·t/C. A step with the conductance of its beginning goes to
    exp(−x), x = f·T³·Δt/C, of where it was, and should to (1 + 3·x)^(−1/3): that is 1.5·x² too low,
    and the sum of all x is ln(T₀/T)."""
    step_s, start_k, heat = 0.1, 1200.0, 50.0
    machine = plant(ALONE, step_s=step_s, ambient_c=ZERO_K_C, initial=f"{start_k + ZERO_K_C} °C")
    for seconds in range(1, 200):
        found_k = run(machine, 10, on=0.0)[0] - ZERO_K_C
        exact_k = (start_k**-3 + 3 * FACTOR * seconds / heat) ** (-1 / 3)
        largest = FACTOR * start_k**3 / heat * step_s
        off = (1.5 + HALF_A_CELL) * largest * math.log(start_k / exact_k)
        assert found_k == pytest.approx(exact_k, rel=off)


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
        powers_w = (2000 - first - inner, first - second, second - third + inner - outer)
        return np.divide(powers_w, (60, 900, 4500))

    fine = solve_ivp(slopes, (0, 3000), [20.0] * 3, method="LSODA", rtol=1e-10, atol=1e-9)
    found = run(machine, 30_000, on=1.0)
    assert found == pytest.approx(fine.y[:, -1], rel=1e-5)


FULL_A = 1.8


def measured(step_s=0.1, **current):
    sense = {"block": {"node": "block"}, "current": {"of": "heater", **current}}
    network = ThermalNetwork.model_validate({**ONE, "sense": sense})
    full_a = {"heater": FULL_A}
    return Plant(network, {"heater": 80.0}, ambient_c=20.0, step_s=step_s, full_a=full_a)


def test_the_current_is_the_mean_of_the_step():
    machine = measured()
    assert machine.currents_a() == {"current": 0.0}
    for active in (1.0, 0.25, 0.0):
        machine.step({"heater": active})
        assert machine.currents_a()["current"] == pytest.approx(active * FULL_A)
    machine = measured()
    machine.step({"heater": 1.0}, 0.0, {"heater": 0.5})  # heat from elsewhere takes no current
    assert machine.currents_a() == {"current": 0.5 * FULL_A}
    assert machine.sensed_c() == {"block": pytest.approx(20 + 160 * (1 - math.exp(-0.1 / 20)))}


def test_behind_a_filter_it_follows_the_exponential():
    machine = measured(step_s=0.02, lag="100 ms")
    for _ in range(10):
        machine.step({"heater": 1.0})
    expected_a = FULL_A * (1 - math.exp(-0.2 / 0.1))
    assert machine.currents_a()["current"] == pytest.approx(expected_a)


QUIET, SINGLE = ("noise: 0.8 K", "noise: 0 K"), ("oversample: 16", "oversample: 1")
RATE = "rise_rate: 20 K/s", "rise_rate: 100 K/s"


def fabricator(*changes):
    """Give it room for noise, too."""
    return spec_of(changed("fabricator", RATE, *changes)).controller


def test_full_current_is_ohms_law():
    """Where the supply is not the rated one; the fabricator's own: its acceptance test."""
    found = fabricator(("rated: 25.57 V", "rated: 40 V"))
    machine = plant_of(found, found.simulation.plant, ambient_c=20.0, step_s=0.1)
    machine.step({"heater": 1.0, "cooler": 0.0})
    assert machine.currents_a() == {"current": pytest.approx(76.6 * 43 / 40**2)}


def test_each_of_the_readings_that_are_summed_up_has_its_own_noise():
    for changes in ((QUIET, SINGLE), (SINGLE,), (QUIET,)):
        assert step_of(fabricator(*changes)) == 0.02  # a tenth of the period of its current
    noisy = fabricator()
    assert step_of(noisy) == 0.01
    assert sums_noise(noisy, "nozzle")
    assert not sums_noise(noisy, "current")


def test_sums_are_as_much_less_noisy_as_their_number_says():
    """Sixteen readings of noise 1.5 K, and of steps of the ADC, of a block at rest."""
    noisy = fabricator(("noise: 0.8 K", "noise: 1.5 K"))
    trace = bench(noisy, ReferenceDevice(noisy), [Event.model_validate({"for": "200 s"})])
    readings_c = trace.steps["nozzle"]["temperature_c"]
    step_k = noisy.sensors["nozzle"].step_at_k(20.0, noisy.board.mcu)
    expected_k = math.sqrt((1.5**2 + step_k**2 / 12) / 16)
    count = len(readings_c)
    assert readings_c.std() == pytest.approx(expected_k, rel=4 / math.sqrt(2 * count))
    assert abs(readings_c.mean() - 20.0) <= step_k / 2
    assert np.all(trace.steps["nozzle"]["duty_percent"] == 0)


SEED = 5
RUN_S = 150.0
PRODUCTS = 2.0**-52 * 2
"""A sum of products is off by so much of the sum of their sizes for each of them, at most."""


def begun(name: str) -> Trace:
    controller = example(name).controller
    scenario = controller.simulated.scenario
    soon = [each for each in scenario if each.for_s is None and (each.at_s or 0.0) < RUN_S]
    events = (*soon, Event.model_validate({"for": "150 s"}))
    return bench(controller, AvrDevice(controller, whole(name)), events, seed=SEED)


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_it_is_the_plant_of_python(name: str) -> None:
    """Given the same, fans, feed, currents and radiation among it, with the same noise."""
    controller, trace = example(name).controller, begun(name)
    simulation = controller.simulated
    plant = plant_of(
        controller, simulation.plant, ambient_c=simulation.ambient_c, step_s=step_of(controller),
        seed=SEED,
    )  # fmt: skip
    hottest_c = max(float(each.max()) for each in trace.temperatures_c.values())
    for row in range(1, len(trace.times_s)):
        given = {output: float(shares[row]) for output, shares in trace.on_fraction.items()}
        plant.step(given, float(trace.fed_mm_per_s[row]))
        found = [*trace.temperatures_c.values(), *trace.sensed_c.values()]
        wanted = [*plant.temperatures_c, *plant.sensed_c().values()]
        bound_k = row * len(wanted) ** 2 * PRODUCTS * hottest_c
        assert np.abs(np.array([each[row] for each in found]) - wanted).max() <= bound_k, row
        for sensor, amperes in plant.currents_a().items():
            assert trace.currents_a[sensor][row] == pytest.approx(amperes, abs=1e-12)


def talk(part: Any) -> object:
    """Return what one who talks with the board has heard of it, and when."""
    if isinstance(part, ModbusMaster):
        return part.polls, part.unanswered, part.slowest_s, part.longest_gap_s, part.values
    return list(part.history) if isinstance(part, Nextion) else None


def course(name: str, change: Callable[[World], None] | None = None) -> list[object]:
    """Return what comes of a reset and a loss of power, bit for bit: in the logs of machine and
    program, and with whom the board talks."""
    controller = example(name).controller
    loop = next(iter(controller.loops))
    world = World(Site(controller, loop, whole(name)), Weather(25.0, 20.0, seed=SEED))
    if change is not None:
        change(world)
    world.set_setpoint(controller.loops[loop].setpoint.maximum_c / 2)
    world.run(10.0)
    world.device.avr.reset()
    world.run(0.5)
    world.power_cut()
    world.run(20.0)
    logs = [world._machine.rows, *(world.device.steps(each) for each in controller.loops)]
    heard = map(talk, world.device.interfaces)
    return [*heard, world.device.avr.cycle, *(log.tobytes() for log in logs)]


def by_hand(world: World) -> None:
    """Have Python look at each step."""
    world.wiring.feel[world.site.loop.sensor] = lambda felt: felt


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_many_steps_are_each_step_by_hand(name: str) -> None:
    assert course(name, by_hand) == course(name)


@pytest.mark.parametrize("name", ["barrel", "dryer", "fabricator", "kiln"])
def test_who_has_c_look_for_him_hears_the_same(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the same times, also of answers that stay away."""
    heard = course(name)
    for kind in (ModbusMaster, Nextion):
        monkeypatch.setattr(kind, "look", None)
    assert course(name) == heard


class Stalling:
    """C that comes back in the middle of a step, as it does by the clock on the wall."""

    def __init__(self, world: World) -> None:
        self._lib, self._avr, self.calls = world._machine._lib, world.device.avr, 0
        world._machine._lib = self

    def __getattr__(self, name: str) -> Any:
        return getattr(self._lib, name)

    def hw_machine_go(self, m: Any, wake: int, fed: int) -> int:
        self.calls += 1
        if self.calls % 2 and m.phase == self._lib.HW_RUNS:
            self._avr.run_to(min(m.until, wake, m.look.at, self._avr.cycle + 5000))
            return int(self._lib.HW_YIELD)
        return int(self._lib.hw_machine_go(m, wake, fed))


@pytest.mark.parametrize("name", ["barrel", "fabricator", "kiln"])
def test_a_computer_that_stalls_changes_nothing(name: str) -> None:
    """Nobody looks at another time because C came back to let Python look up."""
    assert course(name, Stalling) == course(name)
