"""What the catalogue promises for any controller."""

import random
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module

import pytest

from heatwright.sim.faults import catalogue, run_faults, try_fault
from heatwright.sim.faults import run as running
from heatwright.sim.faults.bounds import lasting_s, steps, watchdog_s
from heatwright.sim.faults.healthy import SPREAD, healthy
from heatwright.sim.faults.world import Site
from heatwright.spec import Controller, Sensor, kinds

MACHINES = 6


@pytest.mark.parametrize("kind", kinds(Sensor))
def test_every_kind_of_sensor_has_its_faults(kind: str) -> None:
    assert callable(import_module(f"heatwright.sim.faults.sensors.{kind}").faults)


def test_rules_that_are_off_are_not_expected(site: Site, vary: Callable[..., Controller]) -> None:
    off = vary(heating=None, runaway=None, frozen=None, rising_while_off=None)
    rules = {
        rule for fault in catalogue(off, site.program) if fault.trip for rule in fault.trip.rules
    }
    gone = {"heating_failed", "runaway_above", "sensor_frozen", "rising_while_off"}
    assert not rules & gone
    assert "over_temperature" in rules


def test_a_spec_without_machine(chamber: Controller, site: Site) -> None:
    bare = chamber.model_copy(update={"simulation": None})
    with pytest.raises(ValueError, match="Faults need a machine"):
        catalogue(bare, site.program)


def test_bounds_of_the_chamber(chamber: Controller) -> None:
    loop = chamber.loops["air"]
    assert steps(0.3, loop.model_copy(update={"period_s": 0.1})) == 3
    assert steps(0.5, loop) == 1
    assert lasting_s(60.0, loop) == pytest.approx(61.01)
    assert watchdog_s(chamber) == pytest.approx(2.048 + 0.022, abs=0.001)


@pytest.mark.parametrize("seed", range(MACHINES))
def test_machines_at_random_do_not_trip(site: Site, seed: int) -> None:
    """Every capacity and every resistance by itself, rooms from 10 to 35 °C."""
    chance = random.Random(seed)  # noqa: S311 - machines, not secrets

    def spread(value: float) -> float:
        return value * chance.uniform(1 - SPREAD, 1 + SPREAD)

    network = site.network.model_copy(
        update={
            "nodes": {name: spread(value) for name, value in site.network.nodes.items()},
            "links": tuple(
                link.model_copy(update={"resistance_k_per_w": spread(link.resistance_k_per_w)})
                for link in site.network.links
            ),
        }
    )
    for fault in healthy(site, f"machine {seed}", network, chance.uniform(10.0, 35.0)):
        assert try_fault(fault).detail == ""


def test_all_at_once(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """In order, with progress; the faults themselves are tried one by one elsewhere."""
    monkeypatch.setattr(
        running, "catalogue", lambda *_: catalogue(site.controller, site.program)[:3]
    )
    told: list[tuple[float, float]] = []
    found = run_faults(
        site.controller, site.program, progress=lambda done, total: told.append((done, total))
    )
    assert [each.fault for each in found] == ["unplugged", "shorted_to_ground", "shorted_to_supply"]
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert all(each.passed for each in found)
    assert replace(found[0], problems=("one", "two")).detail == "one; two"
