"""The safety relay in the kilns' whole firmware: closed to fire, open in everything else."""

from collections.abc import Iterator
from typing import Any

import pytest
from rig.avr import whole
from rig.outputs import Recorded
from rig.specs import example

from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice

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

    def on_times(self) -> Iterator[tuple[bool, bool]]:
        """Yield at each change of a pin whether relay and heater are on, the change done."""
        self.device.feed()
        on = {self.relay: False, self.heater: False}
        for change in self.recorded.found:
            on[change.name] = change.on
            yield on[self.relay], on[self.heater]


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
    assert any(heats for _, heats in firing.on_times())
    assert all(relay for relay, heats in firing.on_times() if heats)
    closed, heated = (firing.recorded.cycles(name) for name in (firing.relay, firing.heater))
    assert heated[0] - closed[0] >= 0.0499 * firing.device.avr.clock_hz
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
