"""Each fault, on the binary; and what the catalogue promises for any controller."""

import random

import pytest
from fault_machines import MACHINES, expected, faults_of, site_of, tried

from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.faults.bounds import lasting_s, steps, watchdog_s
from heatwright.sim.faults.healthy import SPREAD, healthy
from heatwright.spec import Controller
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
    assert {rule for fault in found if fault.trip for rule in fault.trip.rules} <= KNOWN


def test_every_rule_of_the_language_is_tripped_by_some_fault() -> None:
    assert {rule for _, _, rule in CASES} >= KNOWN


def test_a_spec_without_machine(chamber: Controller) -> None:
    bare = chamber.model_copy(update={"simulation": None})
    with pytest.raises(ValueError, match="Faults need a machine"):
        catalogue(bare, site_of("chamber").program)


def test_bounds_of_the_chamber(chamber: Controller) -> None:
    loop = chamber.loops["air"]
    assert steps(0.3, loop.model_copy(update={"period_s": 0.1})) == 3
    assert steps(0.5, loop) == 1
    assert lasting_s(60.0, loop) == pytest.approx(61.01)
    assert watchdog_s(chamber) == pytest.approx(2.048 + 0.022, abs=0.001)


@pytest.mark.parametrize("seed", range(6))
def test_machines_at_random_do_not_trip(seed: int) -> None:
    """Every capacity and every resistance by itself, rooms from 10 to 35 °C."""
    chance, site = random.Random(seed), site_of("chamber")  # noqa: S311 - machines, not secrets

    def spread(value: float) -> float:
        return value * chance.uniform(1 - SPREAD, 1 + SPREAD)

    nodes = {name: spread(value) for name, value in site.network.nodes.items()}
    links = tuple(
        link.model_copy(update={"resistance_k_per_w": spread(link.resistance_k_per_w)})
        for link in site.network.links
    )
    network = site.network.model_copy(update={"nodes": nodes, "links": links})
    for fault in healthy(site, f"machine {seed}", network, chance.uniform(10.0, 35.0)):
        assert try_fault(fault).detail == ""
