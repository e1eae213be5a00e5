"""Each fault, on the binary that PlatformIO built."""

import pytest
from rules_tripped import (
    BARE_RULES,
    CHAMBER_RULES,
    EXTRUDER_RULES,
    FABRICATOR_RULES,
    KILN_RULES,
    MENU_FAULTS,
    PID_RULES,
)

from heatwright.sim.faults import Fault, catalogue, try_fault
from heatwright.sim.faults.world import Site
from heatwright.spec.rules import RULES

FOUND: dict[int, dict[str, Fault]] = {}
"""By site: to find what a machine can do takes seconds."""


def faults(site: Site) -> dict[str, Fault]:
    if id(site) not in FOUND:
        found = catalogue(site.controller, site.program)
        FOUND[id(site)] = {fault.id: fault for fault in found}
    return FOUND[id(site)]


def hold(site: Site, name: str, rule: str | None) -> None:
    result = try_fault(faults(site)[name])
    assert result.detail == ""
    assert result.rule == rule


@pytest.mark.parametrize(("name", "rule"), CHAMBER_RULES.items())
def test_the_chamber(site: Site, name: str, rule: str | None) -> None:
    hold(site, name, rule)


@pytest.mark.parametrize(("name", "rule"), PID_RULES.items())
def test_pid_in_windows(pid_site: Site, name: str, rule: str | None) -> None:
    hold(pid_site, name, rule)


# What is healthy does not depend on display and PWM, which takes the simulator long.
@pytest.mark.parametrize(
    ("name", "rule"), [each for each in BARE_RULES.items() if not each[0].startswith("healthy")]
)
def test_pwm_without_display(bare_site: Site, name: str, rule: str | None) -> None:
    hold(bare_site, name, rule)


# The healthy ones are a minute's work: `verify` does it for the example.
@pytest.mark.parametrize(
    ("name", "rule"), [each for each in EXTRUDER_RULES.items() if not each[0].startswith("healthy")]
)
def test_the_extruder_under_its_host(extruder_site: Site, name: str, rule: str | None) -> None:
    hold(extruder_site, name, rule)


@pytest.mark.parametrize(
    ("name", "rule"),
    [each for each in FABRICATOR_RULES.items() if not each[0].startswith("healthy")],
)
def test_the_fabricator_under_its_master(
    fabricator_site: Site, name: str, rule: str | None
) -> None:
    hold(fabricator_site, name, rule)


@pytest.mark.parametrize(
    ("name", "rule"), [each for each in KILN_RULES.items() if not each[0].startswith("healthy")]
)
def test_the_kiln_under_its_display(kiln_site: Site, name: str, rule: str | None) -> None:
    hold(kiln_site, name, rule)


@pytest.mark.parametrize("name", MENU_FAULTS)
def test_the_kiln_under_its_keys(menu_site: Site, name: str) -> None:
    hold(menu_site, name, "sensor_short" if name == "select_stuck" else None)


def test_every_fault_is_tried(  # noqa: PLR0917 - all machines that there are
    site: Site,
    pid_site: Site,
    bare_site: Site,
    extruder_site: Site,
    fabricator_site: Site,
    kiln_site: Site,
) -> None:
    assert list(faults(site)) == list(CHAMBER_RULES)
    assert list(faults(pid_site)) == list(PID_RULES)
    assert list(faults(bare_site)) == list(BARE_RULES)
    assert list(faults(extruder_site)) == list(EXTRUDER_RULES)
    assert list(faults(fabricator_site)) == list(FABRICATOR_RULES)
    assert list(faults(kiln_site)) == list(KILN_RULES)


def test_every_rule_of_the_language_is_tripped_by_some_fault() -> None:
    tripped = {
        *CHAMBER_RULES.values(),
        *PID_RULES.values(),
        *EXTRUDER_RULES.values(),
        *FABRICATOR_RULES.values(),
        *KILN_RULES.values(),
    }
    assert {rule.id for rule in RULES.values()} - tripped == set()
