"""A loop that is switched off and on between two steps begins anew, its limited current small."""

from pathlib import Path

import pytest
from variants import built

from heatwright.sim.elf import Elf
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.spec import load_text

FABRICATOR = Path(__file__).parents[2] / "spec" / "examples" / "fabricator.yaml"
LIMIT_A = 1.2
RAMP_PERCENT = 25.0
SETTLED_S = 6.0
"""Five times what a limited heater takes to its limit, and more."""


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> Site:
    text = FABRICATOR.read_text(encoding="utf-8")
    assert text.count("limit: 3 A") == 1
    spec = load_text(text.replace("limit: 3 A", f"limit: {LIMIT_A} A"), "limited.yaml")
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("limited"))), "nozzle")


@pytest.mark.parametrize("after_s", [0.0, 0.05, 0.1, 0.15])
def test_off_and_on_is_no_way_around_the_limit(limited: Site, after_s: float) -> None:
    """What was not on shows no current, and would have given the next step too much duty."""
    world = World(limited, Weather(100.0, 20.0))
    world.run(1.0)
    world.set_setpoint(250.0)
    world.run(SETTLED_S + after_s)
    before = world.loop("duty_percent")
    assert RAMP_PERCENT < before < 100.0
    master = world.device.master
    for on in (False, True):
        master.ask(master.request("nozzle.enabled", value=on).pdu)
    duties = []
    for _ in range(round(2 * limited.loop.period_s / world.step_s)):
        world.step()
        duties.append(world.loop("duty_percent"))
    assert min(duties) == 0.0
    assert max(duties[duties.index(0.0) :]) <= RAMP_PERCENT
    world.run(SETTLED_S)
    assert world.fault == 0
    assert world.loop("duty_percent") > RAMP_PERCENT
