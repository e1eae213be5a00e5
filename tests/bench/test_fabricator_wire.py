"""The fabricator's wire of 8.54 ohm on 43 V: its heat, its current, what trips, hot and cold. From
a second on the wire is asked for all its power; what it really is the machine knows, and the
firmware measures."""

from dataclasses import replace

import numpy as np
import pytest
from machines import ON_S, events, written
from rig.firmware import ROOT, controller_of, whole

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import Fault, catalogue, effects, try_fault
from heatwright.sim.faults.world import World
from heatwright.sim.trace import Trace
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.board.timers import TICK_S

SUPPLY_V, RATED_V, WIRE_OHM, LIMIT_A = 43.0, 25.57, 8.54, 3.0
RATED_W = 76.6
STARTED_S = 0.5
STEP_A = 5 / 1024 / 0.5
TOLD = 1 + STEP_A / 2 / 1.6
"""Half a step of the ADC, of the least mean that a wire below is held to."""
FULL_DUTY_S = 20.0
HEATED = (
    written(1, nozzle__setpoint="300 °C"),
    written(ON_S, nozzle__enabled=True),
    {"for": f"{ON_S + FULL_DUTY_S} s"},
)
WIRES_OHM = {"hot": 1.05 * WIRE_OHM, "as rated": WIRE_OHM, "cold": 0.95 * WIRE_OHM}
OVER_CURRENT = 20
RATED_OHM = RATED_V**2 / 76.6  # as the spec has it
TRIPS = {
    "heater_shorted": "over_current", "switch_shorted_in_band": "over_current",
    "current_sensor_stands": "current_while_off", "switch_leaking": "current_while_off",
    "current_sensor_torn": "no_current", "heater_open": "no_current",
}  # fmt: skip
"""What happens to wire, switch or sensor, and which rule sees it."""


def machine_of(ohm: float) -> Controller:
    """The fabricator with another wire, as its machine has it: no firmware is made of it."""
    controller = controller_of("fabricator")
    heater = controller.outputs["heater"].model_copy(update={"power_w": RATED_V**2 / ohm})
    outputs = ReadOnlyDict({**controller.outputs, "heater": heater})
    return controller.model_copy(update={"outputs": outputs})


def device_of(kind: str) -> AvrDevice | ReferenceDevice:
    controller = controller_of("fabricator")
    if kind == "model":
        return ReferenceDevice(controller)
    return AvrDevice(controller, whole("fabricator"))


def heated(kind: str, ohm: float) -> Trace:
    return bench(machine_of(ohm), device_of(kind), events(*HEATED))


def loads(trace: Trace, ohm: float) -> tuple[np.ndarray, np.ndarray]:
    """Heat, W, and root mean square, A, half a second after it is on and later."""
    later = trace.times_s >= ON_S + STARTED_S
    mean_a = np.asarray(trace.currents_a["current"])[later]
    return SUPPLY_V * mean_a, np.sqrt(mean_a * SUPPLY_V / ohm)


@pytest.mark.parametrize("kind", ["model", "binary"])
@pytest.mark.parametrize("name", WIRES_OHM)
def test_it_never_has_more_than_its_power_and_its_current(name: str, kind: str) -> None:
    ohm = WIRES_OHM[name]
    trace = heated(kind, ohm)
    (log,) = trace.steps.values()
    assert set(log["fault.code"]) == {0}
    heat_w, rms_a = loads(trace, ohm)
    told = TOLD if name == "cold" else 1.0  # the others are held by their rated voltage
    assert rms_a.max() <= LIMIT_A * told
    assert heat_w.max() <= RATED_W
    assert rms_a.max() == pytest.approx(min(LIMIT_A, RATED_V / ohm), rel=TOLD - 1)


def test_the_page_tells_what_flows() -> None:
    page = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")
    ohm = WIRES_OHM["cold"]
    heat_w, rms_a = loads(heated("binary", ohm), ohm)
    assert f"{rms_a.max():.3f} A through the cold wire" in page
    assert f"whose mean of {heat_w.max() / SUPPLY_V:.1f} A the ADC resolves to 5 mA" in page
    assert f"the rated wire takes {RATED_V / RATED_OHM:.3f} A" in page


@pytest.mark.parametrize("kind", ["model", "binary"])
def test_half_of_it_gets_a_quarter_of_the_time(kind: str) -> None:
    """Turns that touch each other: 3 A still, and half of the heat."""
    trace = heated(kind, WIRE_OHM / 2)
    (log,) = trace.steps.values()
    assert set(log["fault.code"]) == {0}
    heat_w, rms_a = loads(trace, WIRE_OHM / 2)
    coarse = 1 + STEP_A / 2 / 0.8
    assert rms_a.max() <= LIMIT_A * coarse
    assert heat_w.max() == pytest.approx(LIMIT_A**2 * WIRE_OHM / 2, rel=2.01 * (coarse - 1))


@pytest.mark.parametrize("kind", ["model", "binary"])
def test_a_sixth_of_it_is_a_fault_before_half_a_second(kind: str) -> None:
    trace = heated(kind, WIRE_OHM / 6)
    (log,) = trace.steps.values()
    tripped_s = log["time_s"][(log["fault.code"] == OVER_CURRENT).argmax()]
    heats_s = log["time_s"][(log["duty_percent"] > 0).argmax()]
    assert set(log["fault.code"]) == {0, OVER_CURRENT}
    assert tripped_s - heats_s < STARTED_S


@pytest.mark.parametrize("kind", ["model", "binary"])
@pytest.mark.parametrize("name", WIRES_OHM)
def test_it_begins_with_a_quarter_and_has_all_that_it_bears_in_four_steps(
    name: str, kind: str
) -> None:
    """The fourth duty is what the mean of the third leaves, which half a step of the ADC blurs."""
    ohm = WIRES_OHM[name]
    (log,) = heated(kind, ohm).steps.values()
    duties = log["duty_percent"][log["duty_percent"] > 0]
    third_a = 0.75 * RATED_V**2 / ohm / SUPPLY_V
    borne_percent = 100 * min(1.0, (LIMIT_A * ohm / RATED_V) ** 2)
    assert duties[:3].tolist() == [25.0, 50.0, 75.0]
    assert duties[3] == pytest.approx(borne_percent, rel=2.01 * STEP_A / 2 / third_a)


class Wired:
    """Faults of the catalogue, on a fabricator whose wire is another one all the time."""

    def __init__(self, ohm: float) -> None:
        self._times = RATED_OHM / ohm

    def fault(self, name: str) -> Fault:
        every = catalogue(controller_of("fabricator"), whole("fabricator"))
        (found,) = (fault for fault in every if fault.id == name)

        def make() -> World:
            world = found.make()
            self._put(world)
            world.run(STARTED_S)
            return world

        def cause(world: World) -> None:
            found.cause(world)
            broken = world.wiring.heat["heater"]
            if broken != effects.weakened(self._times):
                world.wiring.heat["heater"] = broken._replace(
                    times=broken.times * self._times, least=broken.least * self._times
                )

        def cure(world: World) -> None:
            found.cure(world)
            self._put(world)

        return replace(found, make=make, cause=cause, cure=cure)

    def _put(self, world: World) -> None:
        world.wiring.heat["heater"] = effects.weakened(self._times)


@pytest.mark.parametrize("name", WIRES_OHM)
@pytest.mark.parametrize(("fault", "rule"), TRIPS.items())
def test_rules_20_to_22_trip_on_it_and_it_is_off(fault: str, rule: str, name: str) -> None:
    """What else a trip has to be is judged with it: told, latched, kept, acknowledged."""
    found = try_fault(Wired(WIRES_OHM[name]).fault(fault))
    assert (found.detail, found.rule) == ("", rule)
    assert found.tripped_after_s is not None
    assert found.heater_off_after_s is not None
    assert found.heater_off_after_s <= found.tripped_after_s + TICK_S
