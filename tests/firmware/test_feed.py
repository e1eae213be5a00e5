"""The feeder's whole firmware while its main loop hangs; how it feeds: see gcode and outputs."""

from types import SimpleNamespace

import pytest
from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.processor import INTERRUPTS_OFF, INTERRUPTS_ON, hang
from heatwright.sim.outputs.stepper import Stepper
from heatwright.spec.rules import RULES

FEEDER = example("feeder").controller
HOT_C = 210.0
STEPS_PER_MM, SPEED_MM_PER_S = 128, 20


def feed_of(device: AvrDevice) -> Stepper:
    device.feed()
    found = device.outputs["feed"]
    assert isinstance(found, Stepper)
    return found


@pytest.mark.parametrize("entry", [INTERRUPTS_ON, INTERRUPTS_OFF])
def test_a_main_loop_that_hangs_ends_it(entry: str) -> None:
    """The gate's permit lasts ten ticks; then the watchdog resets the chip."""
    device = AvrDevice(FEEDER, whole("feeder"))
    device.sense("nozzle", HOT_C)
    device.advance(1.0)
    for line in (f"M104 S{HOT_C:g}", "M83", f"G1 E200 F{60 * SPEED_MM_PER_S}"):
        device.send(line)
    device.advance(6.0)
    before = feed_of(device).position
    assert before > SPEED_MM_PER_S * STEPS_PER_MM
    world = SimpleNamespace(device=device, site=SimpleNamespace(controller=FEEDER))
    hang(world, entry)  # type: ignore[arg-type]
    device.advance(6.5)
    assert feed_of(device).position - before <= (0.1 + 2 * 0.01) * SPEED_MM_PER_S * STEPS_PER_MM
    assert feed_of(device).on == (entry == INTERRUPTS_OFF)
    device.advance(10.0)
    assert RULES[int(device.read("fault.code"))].id == "watchdog_reset"
    assert not feed_of(device).on
