"""The feeder's own firmware: it feeds exactly, only hot, and not after a fault."""

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
STEPS_PER_MM = 128


@pytest.fixture
def device() -> AvrDevice:
    """The feeder, its nozzle held at the setpoint from outside."""
    found = AvrDevice(FEEDER, whole("feeder"))
    found.sense("nozzle", HOT_C)
    found.advance(1.0)
    found.send(f"M104 S{HOT_C:g}")
    found.send("M83")
    found.advance(3.0)
    return found


def feed_of(device: AvrDevice) -> Stepper:
    device.feed()
    found = device.outputs["feed"]
    assert isinstance(found, Stepper)
    return found


def test_it_feeds_what_it_is_told(device: AvrDevice) -> None:
    device.send("G1 E40 F1200")  # 20 mm/s
    device.advance(7.0)
    feed = feed_of(device)
    assert feed.position == 40 * STEPS_PER_MM
    assert (feed.violations, feed.missed) == (0, 0)
    assert device.travel_mm("feed") == 40.0
    assert device.travel_mm("heater") == 0.0
    device.send("G1 E-2.5 F300")
    device.advance(9.0)
    assert feed_of(device).position_mm == 37.5
    assert device.read("fault.code") == 0


def test_it_waits_for_the_heat(device: AvrDevice) -> None:
    device.send("G1 E200 F600")  # 20 s
    device.advance(6.0)
    assert 20 < feed_of(device).position_mm < 30
    device.sense("nozzle", HOT_C - 3.0)  # ready_within is 1 K
    device.advance(7.0)
    waiting_mm = feed_of(device).position_mm
    device.advance(10.0)
    assert feed_of(device).position_mm == waiting_mm
    device.sense("nozzle", HOT_C)
    device.advance(40.0)
    assert feed_of(device).position_mm == 200.0
    assert feed_of(device).violations == 0


def test_a_fault_ends_it(device: AvrDevice) -> None:
    device.send("G1 E200 F1200")
    device.advance(6.0)
    before = feed_of(device).position
    device.send("M112")
    device.advance(6.2)
    assert device.read("fault.code") != 0
    stopped = feed_of(device).position
    # 20 ms on the line, and a tick or two until the step that sees it.
    assert stopped - before < 0.1 * 20 * STEPS_PER_MM
    assert not feed_of(device).on
    device.send("M999")
    device.advance(30.0)
    assert feed_of(device).position == stopped  # what was left is forgotten


@pytest.mark.parametrize("entry", [INTERRUPTS_ON, INTERRUPTS_OFF])
def test_a_main_loop_that_hangs_ends_it(device: AvrDevice, entry: str) -> None:
    """The gate's permit lasts ten ticks; then the watchdog resets the chip."""
    device.send("G1 E200 F1200")
    device.advance(6.0)
    before = feed_of(device).position
    world = SimpleNamespace(device=device, site=SimpleNamespace(controller=FEEDER))
    hang(world, entry)  # type: ignore[arg-type]
    device.advance(6.5)
    assert feed_of(device).position - before <= (0.1 + 2 * 0.01) * 20 * STEPS_PER_MM
    assert feed_of(device).on == (entry == INTERRUPTS_OFF)
    device.advance(10.0)
    assert RULES[int(device.read("fault.code"))].id == "watchdog_reset"
    assert not feed_of(device).on
