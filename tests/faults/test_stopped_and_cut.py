"""Somebody stops or pauses a firing and pulls the plug: it does not go on with the power back."""

import pytest
from fault_machines import site_of

from heatwright.sim.faults.programs import under_way
from heatwright.sim.reference.program_state import IDLE, PAUSED, RESTORING, RUNNING
from heatwright.spec.program_orders import Order

HEARD_S = 0.05
"""From the display to the order: its line, and a tick."""
WRITTEN_S = 0.47
"""A record of progress has 45 bytes, one a tick of 10 ms; and there is the tick it begins in."""
WATCH_S = 20.0


def after_a_cut(order: Order, within_s: float) -> tuple[int, float | None]:
    """The program's state when the power is back for a while, and when a heater was on last."""
    world = under_way(site_of("kiln"))
    world.device.program(order)
    world.run(within_s)
    world.power_cut()
    world.run(WATCH_S)
    return int(world.device.read("program.state")), world.heaters.last_on_s(world.power_on_s)


@pytest.mark.parametrize(("order", "state"), [("stop", IDLE), ("pause", PAUSED)])
@pytest.mark.parametrize("more_s", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
def test_it_does_not_go_on(order: Order, state: int, more_s: float) -> None:
    assert after_a_cut(order, HEARD_S + WRITTEN_S + more_s) == (state, None)


def test_what_is_cut_before_that_may_go_on() -> None:
    """Else the test above would show nothing."""
    state, _ = after_a_cut("stop", HEARD_S)
    assert state not in (IDLE, PAUSED, RESTORING)
    assert state >= RUNNING
