"""Each fault, on the binary."""

import pytest
from fault_machines import MACHINES, expected, faults_of, site_of, tried

from heatwright.sim.faults import catalogue, try_fault
from heatwright.spec.rules import RULES

KNOWN = {rule.id for rule in RULES.values()}
CASES = [(machine, *each) for machine in MACHINES for each in tried(machine).items()]


@pytest.mark.parametrize(("machine", "name", "rule"), CASES)
def test_it_trips_its_rule_and_no_other(machine: str, name: str, rule: str | None) -> None:
    result = try_fault(faults_of(machine)[name])
    assert (result.detail, result.rule) == ("", rule)


@pytest.mark.parametrize("machine", MACHINES)
def test_the_catalogue_has_each_once_and_no_other(machine: str) -> None:
    """What the specification lets one expect, and nothing that nobody expects."""
    found = catalogue(site_of(machine).controller, site_of(machine).program)
    assert sorted(fault.id for fault in found) == sorted(expected(machine))
    trips = [trip for fault in found for trip in (fault.trip, fault.again) if trip]
    assert {rule for trip in trips for rule in trip.rules} <= KNOWN


def test_every_rule_of_the_language_is_tripped_by_some_fault() -> None:
    assert {rule for _, _, rule in CASES} >= KNOWN
