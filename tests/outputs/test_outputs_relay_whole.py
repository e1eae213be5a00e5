"""The safety relay in whole firmware: of two loops under a G-code host, and of the kilns."""

from typing import Any

import numpy as np
import pytest
from rig.firmware import began_s, device_of, example, whole
from rig.outputs import TICK_S, Recorded

from heatwright.sim.binary.elf import Elf
from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice

SPEC = """
heatwright: 1
controller: {name: hosted, board: mega2560}
sensors:
  left: {kind: ds18b20, pin: D22}
  right: {kind: ds18b20, pin: D23}
outputs:
  left: {kind: pwm, pin: D2, frequency: 490 Hz, active: low, power: 40 W}
  right: {kind: digital, pin: D3, power: 40 W}
  contactor: {kind: digital, pin: D9, active: low}
  fan: {kind: digital, pin: D7, minimum_on: 3 s, minimum_off: 2 s}
loops:
  left:
    {sensor: left, heater: left, period: 1 s, algorithm: {kind: pid, kp: 10, ki: 0.1},
     setpoint: {initial: 0 °C, minimum: 20 °C, maximum: 70 °C}}
  right:
    {sensor: right, heater: right, period: 1 s, algorithm: {kind: on_off, hysteresis: 1 K},
     setpoint: {initial: 0 °C, minimum: 20 °C, maximum: 70 °C}}
safety: {relay: contactor%s}
interfaces: [{kind: gcode, loops: {T0: left, T1: right}, fans: {P0: fan}}]
"""
HEARD_S = 3.0
SETTLED_S = 0.0499


@pytest.fixture(params=["", ", relay_feedback: D10"])
def device(request: pytest.FixtureRequest) -> AvrDevice:
    return powered(SPEC % request.param)


def powered(text: str, elf: Elf | None = None) -> AvrDevice:
    made = device_of(text, 20.0, elf)
    made.log_edges(made.outputs)
    made.advance(5.0)
    return made


def after(device: AvrDevice, line: str) -> tuple[bool, bool, bool]:
    """Send a line; tell of the relay, and whether each heater has been on since it was heard."""
    device.send(line)
    device.advance(device.time_s + HEARD_S)
    for heater in ("left", "right"):
        device.on_fraction(heater)
    device.advance(device.time_s + HEARD_S)
    assert device.relay is not None
    assert device.relay.closed == device.outputs["contactor"].on
    return (device.relay.closed, *(device.on_fraction(name) > 0 for name in ("left", "right")))


def test_it_is_closed_while_a_loop_is_on(device: AvrDevice) -> None:
    recorded = Recorded(device, "contactor", "left", "right")
    assert after(device, "M105") == (False, False, False)
    assert after(device, "M104 T0 S50") == (True, True, False)
    assert after(device, "M104 T1 S50") == (True, True, True)
    assert after(device, "M104 T0 S0") == (True, False, True)
    assert after(device, "M104 T1 S0") == (False, False, False)
    assert after(device, "M104 T0 D30") == (True, True, False)
    assert after(device, "M112") == (False, False, False)
    assert after(device, "M999") == (False, False, False)
    assert after(device, "M104 T1 S40") == (True, False, True)
    device.feed()
    closed_at = np.inf
    for change in recorded.found:
        if change.name == "contactor":
            closed_at = change.cycle if change.on else np.inf
        elif change.on:
            assert change.cycle - closed_at >= SETTLED_S * device.avr.clock_hz
    device.sense("left", 21.0)
    device.power_cycle()
    assert after(device, "M105") == (False, False, False)


def test_a_reset_connects_no_heater_to_the_timer() -> None:
    """To switch the one heater off must not connect the other: on one timer, and on where low."""
    other = "kind: pwm, pin: D3, frequency: 490 Hz, active: low"
    device = powered(SPEC.replace("kind: digital, pin: D3", other) % "")
    device.avr.pins.take()
    device.avr.reset()
    device.avr.run(0.05)
    events = device.avr.pins.take()
    heaters = [device.outputs[name].number for name in ("left", "right")]
    mine = events[np.isin(events["pin"], heaters)]
    assert len(mine)
    assert (mine["state"] & 1).all()


def test_a_fan_of_the_host_keeps_its_minimum_times() -> None:
    device = device_of(SPEC % "")
    recorded = Recorded(device, "fan")
    orders = ("M106 P0 S255", 2.5), ("M107 P0", 4.0), ("M106 P0 S255", 0.5), ("M107 P0", 10.0)
    device.advance(0.5)
    for line, seconds in orders:
        device.send(line)
        device.advance(device.time_s + seconds)
    device.feed()
    first, off, again, end = (cycle / device.avr.clock_hz for cycle in recorded.cycles("fan"))
    # Off for two seconds from the start on, which is noted a part of a tick late.
    assert 2.0 - TICK_S / 10 <= first - began_s(SPEC % "") <= 2.0 + 2 * TICK_S
    assert abs(off - first - 3.0) < 1e-3
    assert again - off >= 2.0 - TICK_S / 10  # some cycles sooner in its tick than the one before
    assert abs(end - again - 3.0) < 1e-3


TOLD_S = 3.15
"""What is touched, or keyed, has been heard, a control step has passed, and the relay has followed:
100 ms in which its contact is looked at, and its own time."""


class Firing:
    """A kiln at 20 °C whose operator orders its program about."""

    def __init__(self, name: str) -> None:
        self.controller = example(name).controller
        self.device = AvrDevice(self.controller, whole(name))
        self.relay = str(self.controller.safety.relay)
        self.heater = self.controller.loops["chamber"].heater
        self.device.sense("chamber", 20.0)
        self.recorded = Recorded(self.device, self.relay, self.heater)
        self.run(2.0)

    def run(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)

    def order(self, order: Any, number: int = 0) -> bool:
        """Order the program about; say whether the relay's coil and contacts are on then."""
        self.device.program(order, number)
        self.run(TOLD_S)
        assert self.device.relay is not None
        assert self.device.outputs[self.relay].on == self.device.relay.closed
        return self.device.relay.closed


@pytest.fixture(params=("kiln", "kiln_uno"))
def firing(request: pytest.FixtureRequest) -> Firing:
    return Firing(request.param)


def test_it_is_closed_to_fire_and_open_in_everything_else(firing: Firing) -> None:
    """It does not chatter: a contactor lives for some hundred thousand switchings."""
    assert not firing.device.outputs[firing.relay].on
    assert firing.order("start", 1)
    firing.run(120.0)
    assert not firing.order("pause")
    assert firing.order("resume")
    assert not firing.order("stop")
    firing.device.feed()
    on, heated_times = {firing.relay: False, firing.heater: False}, 0
    for change in firing.recorded.found:
        on[change.name] = change.on
        heated_times += on[firing.heater]
        assert on[firing.relay] or not on[firing.heater]
    assert heated_times
    closed, heated = (firing.recorded.cycles(name) for name in (firing.relay, firing.heater))
    assert heated[0] - closed[0] >= SETTLED_S * firing.device.avr.clock_hz
    assert len(closed) == 4


def test_without_power_a_dead_triac_gets_no_current(firing: Firing) -> None:
    coupling = Coupling(firing.controller, firing.device, 1.0)
    relay, shorted, none = firing.device.relay, {firing.heater: 1.0}, {firing.heater: 0.0}
    assert relay is not None
    for order, supplied in (("start", shorted), ("pause", none)):
        firing.order(order, 1)
        coupling.supplied(shorted)
        firing.run(1.0)
        assert coupling.supplied(shorted) == supplied
    firing.order("resume")
    relay.power_off()
    assert coupling.supplied(shorted) == none
    firing.device.power_cycle()
    coupling.supplied(shorted)
    firing.run(0.5)
    assert coupling.supplied(shorted) == none
