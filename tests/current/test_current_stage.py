"""The timing of a loop with a measured current is taken while it heats, not while it is latched."""

import pytest
from kettle import KETTLES, kettle
from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.timing.stage import Stage


@pytest.mark.parametrize("name", KETTLES)
def test_a_kettle_heats_and_trips_nothing(name: str) -> None:
    site = kettle(name)
    device = AvrDevice(site.controller, site.program)
    stage, heated = Stage(site.controller, device), 0
    stage.advance(5.0)
    device.press("up")
    for second in range(6, 110):
        stage.advance(second)
        device.press(None)
        heated += device.read("current_heater.applied_percent") > 0
        assert not device.read("fault.code")
    assert heated >= 30


@pytest.mark.parametrize("name", ["fabricator", "dryer"])
def test_what_a_master_switches_is_on(name: str) -> None:
    controller = example(name).controller
    device = AvrDevice(controller, whole(name))
    Stage(controller, device).advance(60.0)
    ((loop, _),) = controller.loops.items()
    assert device.read(f"loop_{loop}.enabled") == 1
    assert not device.read("fault.code")
