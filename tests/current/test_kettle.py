"""A bed with a measured current: each fault of its sensor, and the state that is timed."""

import pytest
from rig.analog_specs import KEYS, bed
from rig.avr import whole
from rig.specs import changed, example, spec_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.faults.world import Site
from heatwright.sim.timing.stage import Stage

PID = "algorithm: {kind: pid, kp: 12, ki: 0.1, kd: 60, derivative_filter: 2 s}"
LIMITED = "kind: pwm, frequency: 976.5625 Hz, current: {sensor: amps, limit: 8 A}"
TRIPPED = "kind: digital, current: {sensor: amps, trip: 12 A}"
HEATERS = {"limited": (LIMITED, PID),
           "tripped": (TRIPPED, "algorithm: {kind: on_off, hysteresis: 1 K}")}  # fmt: skip
"""What the file says of the heater, and the loop's algorithm."""


def heated(name: str) -> Site:
    heater, algorithm = HEATERS[name]
    text = changed(
        bed("hotend", interface=KEYS),
        ("\noutputs:", "\n  amps: {kind: current, pin: A2, scale: 0.25 V/A}\noutputs:"),
        ("kind: pwm, pin: D3, frequency: 490 Hz, power: 120 W",
         f"{heater}, pin: D3, power: 240 W, supply: 24 V"),
        (PID, algorithm),
        ("within: 60 s", "within: 300 s"),  # Stage swings it about one temperature
        ("lag: 4 s}", "lag: 4 s}, amps: {of: heater, lag: 20 ms}"),
    )  # fmt: skip
    return Site(spec_of(text).controller, whole(text), "bed")


RULES = {
    "current_sensor_torn": "no_current",
    "current_sensor_at_supply": "over_current",
    "current_sensor_stands": "current_while_off",
}


@pytest.fixture(scope="module", params=HEATERS)
def site(request: pytest.FixtureRequest) -> Site:
    return heated(request.param)


@pytest.mark.parametrize(("name", "rule"), RULES.items())
def test_it_trips(site: Site, name: str, rule: str) -> None:
    found = {fault.id: fault for fault in catalogue(site.controller, site.program)}
    result = try_fault(found[name])
    assert result.detail == ""
    assert result.rule == rule


@pytest.mark.parametrize("name", HEATERS)
def test_it_is_timed_while_it_heats(name: str) -> None:
    site = heated(name)
    device = AvrDevice(site.controller, site.program)
    stage, on_s = Stage(site.controller, device), 0
    stage.advance(5.0)
    device.press("up")
    for second in range(6, 110):
        stage.advance(second)
        device.press(None)
        on_s += device.read("current_heater.applied_percent") > 0
        assert not device.read("fault.code")
    assert on_s >= 30


@pytest.mark.parametrize("name", ["fabricator", "dryer"])
def test_what_a_master_switches_is_on(name: str) -> None:
    controller = example(name).controller
    device = AvrDevice(controller, whole(name))
    Stage(controller, device).advance(60.0)
    ((loop, _),) = controller.loops.items()
    assert device.read(f"loop_{loop}.enabled") == 1
    assert not device.read("fault.code")
