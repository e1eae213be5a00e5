"""A plant in C beside its processor is the plant in Python; many steps at once are each step."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from rig.firmware import EXAMPLE_NAMES, example, whole

from heatwright.sim.bench import bench, step_of
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.site import Site
from heatwright.sim.faults.world import Weather, World
from heatwright.sim.interfaces.modbus_rtu import ModbusMaster
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.plants import plant_of
from heatwright.sim.trace import Trace
from heatwright.spec import Event

SEED = 5
RUN_S = 150.0
PRODUCTS = 2.0**-52 * 2
"""A sum of products is off by so much of the sum of their sizes for each of them, at most."""


def run(name: str) -> Trace:
    """Run the first minutes of an example's scenario on its binary."""
    controller = example(name).controller
    assert controller.simulation is not None
    soon = [each for each in controller.simulation.scenario if (each.at_s or 0.0) < RUN_S]
    events = (
        *(each for each in soon if each.for_s is None),
        Event.model_validate({"for": "150 s"}),
    )
    return bench(controller, AvrDevice(controller, whole(name)), events, seed=SEED)


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_it_is_the_plant_of_python(name: str) -> None:
    """Given the same, fans, feed, currents and radiation among it, with the same noise."""
    controller, trace = example(name).controller, run(name)
    simulation = controller.simulation
    assert simulation is not None
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
