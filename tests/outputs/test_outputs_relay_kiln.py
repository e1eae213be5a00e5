"""The safety relay in the kilns' whole firmware: closed to fire, open in everything else."""

from collections.abc import Iterator
from typing import Any

import pytest
from rig.avr import whole
from rig.outputs import Recorded
from rig.specs import example

from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice
from heatwright.sim.native.relay import Armature
from heatwright.sim.outputs.switch import Switch
from heatwright.spec.rules import RULES

KILNS = ("kiln", "kiln_uno")
TOLD_S = 3.0
"""What is touched, or keyed, has been heard, and a control step has passed."""
FOLLOWS_S = 0.15
"""Within this long the relay has followed, once it is told: 100 ms in which its contact is looked
at, and its own time."""


class Firing:
    """A kiln at 20 °C whose operator orders its program about."""

    def __init__(self, name: str) -> None:
        self.controller = example(name).controller
        self.device = AvrDevice(self.controller, whole(name))
        relay = self.controller.safety.relay
        assert relay is not None
        self.coil: Switch = self.device.outputs[relay]
        self.heater_name = self.controller.loops["chamber"].heater
        self.device.sense("chamber", 20.0)
        self.relay_name = relay
        self.recorded = Recorded(self.device, relay, self.heater_name)
        self.run(2.0)

    def run(self, seconds: float) -> None:
        """Go on."""
        self.device.advance(self.device.time_s + seconds)

    def order(self, order: Any, number: int = 0) -> None:
        """Order the program about."""
        self.device.program(order, number)
        self.run(TOLD_S + FOLLOWS_S)

    @property
    def is_closed(self) -> bool:
        """Whether the relay's coil and contacts are on; they must agree."""
        assert self.device.relay is not None
        assert self.coil.on == self.device.relay.closed
        return self.coil.on

    def on_times(self) -> Iterator[tuple[bool, bool]]:
        """Yield at each change of a pin whether relay and heater are on, the change done."""
        self.device.feed()
        on = {self.relay_name: False, self.heater_name: False}
        for change in self.recorded.found:
            on[change.name] = change.on
            yield on[self.relay_name], on[self.heater_name]


@pytest.fixture(params=KILNS)
def firing(request: pytest.FixtureRequest) -> Firing:
    return Firing(request.param)


def test_it_is_closed_to_fire_and_open_in_everything_else(firing: Firing) -> None:
    assert not firing.is_closed
    firing.order("start", 1)
    assert firing.is_closed
    firing.order("pause")
    assert not firing.is_closed
    firing.order("resume")
    assert firing.is_closed
    firing.order("stop")
    assert not firing.is_closed
    assert any(heats for _, heats in firing.on_times())
    assert all(relay for relay, heats in firing.on_times() if heats)


def test_the_heater_waits_for_it(firing: Firing) -> None:
    firing.order("start", 1)
    firing.run(5.0)
    firing.device.feed()
    closed, heated = (
        firing.recorded.cycles(name)[0] for name in (firing.relay_name, firing.heater_name)
    )
    assert heated - closed >= 0.0499 * firing.device.avr.clock_hz


def test_welded_it_is_found_when_it_should_open(firing: Firing) -> None:
    assert firing.device.relay is not None
    firing.order("start", 1)
    firing.device.relay.fail(Armature.WELDED)
    firing.run(5.0)
    assert not firing.device.read("fault.code")
    firing.device.program("pause", 0)
    firing.run(TOLD_S)
    assert RULES[int(firing.device.read("fault.code"))].id == "relay_welded"
    firing.device.feed()
    assert not firing.device.outputs[firing.heater_name].on


def test_without_power_a_dead_triac_gets_no_current(firing: Firing) -> None:
    assert firing.device.relay is not None
    coupling = Coupling(firing.controller, firing.device, 1.0)
    shorted = {firing.heater_name: 1.0}
    firing.order("start", 1)
    coupling.supplied(shorted)
    firing.run(1.0)
    assert coupling.supplied(shorted) == shorted
    firing.order("pause")
    coupling.supplied(shorted)
    firing.run(1.0)
    assert coupling.supplied(shorted) == {firing.heater_name: 0.0}
    firing.order("resume")
    firing.device.relay.power_off()
    assert coupling.supplied(shorted) == {firing.heater_name: 0.0}
    firing.device.power_cycle()
    coupling.supplied(shorted)
    firing.run(0.5)
    assert coupling.supplied(shorted) == {firing.heater_name: 0.0}


def test_it_is_told_no_more_often_than_the_operator_wants(firing: Firing) -> None:
    """It does not chatter: a contactor lives for some hundred thousand switchings."""
    firing.order("start", 1)
    firing.run(120.0)
    firing.device.feed()
    assert len(firing.recorded.cycles(firing.relay_name)) == 1


def test_one_that_does_not_close_is_found_while_it_fires(firing: Firing) -> None:
    assert firing.device.relay is not None
    firing.order("start", 1)
    firing.device.relay.fail(Armature.DEAD)
    firing.run(TOLD_S)
    assert RULES[int(firing.device.read("fault.code"))].id == "relay_open"
