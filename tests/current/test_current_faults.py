"""Every fault of a current's sensor trips its rule, on a limited and on a switched heater."""

import pytest
from kettle import KETTLES, kettle

from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.faults.world import Site

RULES = {
    "current_sensor_torn": "no_current",
    "current_sensor_at_supply": "over_current",
    "current_sensor_stands": "current_while_off",
}


@pytest.fixture(scope="module", params=KETTLES)
def site(request: pytest.FixtureRequest) -> Site:
    return kettle(request.param)


@pytest.mark.parametrize(("name", "rule"), RULES.items())
def test_it_trips(site: Site, name: str, rule: str) -> None:
    found = {fault.id: fault for fault in catalogue(site.controller, site.program)}
    result = try_fault(found[name])
    assert result.detail == ""
    assert result.rule == rule
