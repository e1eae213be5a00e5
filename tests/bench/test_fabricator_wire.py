"""The fabricator's wire of 8.54 ohm on 43 V: its heat and its current, cold, hot, and half shorted.

From a second on the wire is asked for all its power; what it really is the machine knows, and the
firmware measures.
"""

import numpy as np
import pytest
from machines import ON_S, events, written
from rig.avr import whole
from rig.specs import controller_of

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.trace import Trace
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

SUPPLY_V, RATED_V, WIRE_OHM, LIMIT_A = 43.0, 25.58, 8.54, 3.0
RATED_W = 76.65
"""76.6 W as they are printed; √(76.6 W · 8.54 Ω) is 25.577 V."""
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
