"""A loop that is switched off and on between two steps begins anew, its limited current small."""

from pathlib import Path

import pytest
from whole_firmware import Broken, spec_of, whole

from heatwright.sim.faults.world import Site, Weather, World

FABRICATOR = Path(__file__).parents[2] / "spec" / "examples" / "fabricator.yaml"
LIMIT_A = 1.2
RAMP_PERCENT = 25.0
SETTLED_S = 6.0
"""Five times what a limited heater takes to its limit, and more."""


TEXT = FABRICATOR.read_text(encoding="utf-8").replace("limit: 3 A", f"limit: {LIMIT_A} A")
BROKEN = (
    Broken("loop_nozzle.c", " && !off_is_due", ""),
    Broken("loop_nozzle.c", "    off_is_due = loop_nozzle.enabled;\n", ""),
)


def duties_after_off_and_on(after_s: float, broken: Broken | None = None) -> tuple[World, float]:
    """The world, and the highest duty from the switching on in two steps."""
    controller = spec_of(TEXT).controller
    world = World(Site(controller, whole(TEXT, broken), "nozzle"), Weather(100.0, 20.0))
    world.run(1.0)
    world.set_setpoint(250.0)
    world.run(SETTLED_S + after_s)
    assert RAMP_PERCENT < world.loop("duty_percent") < 100.0
    master = world.device.master
    for on in (False, True):
        master.ask(master.request("nozzle.enabled", value=on).pdu)
    world.run(world.site.loop.period_s)
    first = world.loop("duty_percent")
    world.run(world.site.loop.period_s)
    return world, max(first, world.loop("duty_percent"))


@pytest.mark.parametrize("after_s", [0.0, 0.05, 0.1])
def test_off_and_on_is_no_way_around_the_limit(after_s: float) -> None:
    """What was not on shows no current, and would have given the next step too much duty."""
    world, highest = duties_after_off_and_on(after_s)
    assert highest <= RAMP_PERCENT
    world.run(SETTLED_S)
    assert world.fault == 0
    assert world.loop("duty_percent") > RAMP_PERCENT


@pytest.mark.parametrize("broken", BROKEN)
def test_unless_the_next_step_takes_the_off_over(broken: Broken) -> None:
    _, highest = duties_after_off_and_on(0.0, broken)
    assert highest > RAMP_PERCENT
