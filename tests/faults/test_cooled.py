"""A cooler with minimum times, no current to tell: what still protects, and what cools."""

from pathlib import Path

import pytest
from variants import built

from heatwright.sim.elf import Elf
from heatwright.sim.faults import catalogue, starts, try_fault
from heatwright.sim.faults.effects import shorted
from heatwright.sim.faults.machine import steady_c
from heatwright.sim.faults.world import Site
from heatwright.spec import load_text

FABRICATOR = Path(__file__).parents[2] / "spec" / "examples" / "fabricator.yaml"
HELD = (
    (", current: {sensor: current, limit: 3 A}", ""),
    ("  current: {kind: current, pin: PA1, scale: 0.2 V/A, oversample: 4}\n", ""),
    (", current: {of: heater}", ""),
    ("{kind: digital, pin: PD6}",
     "{kind: digital, pin: PD6, minimum_on: 1500 ms, minimum_off: 3 s}"),
)  # fmt: skip
RULES = {
    "open": "sensor_open",
    "heater_open": "heating_failed",
    "switch_shorted_when_hot": "over_temperature",
    "switch_shorted_in_band": "runaway_above",
    "fire": "over_temperature",
    "cooler_shorted": "heating_failed",
    "heating_and_cooling_by_turns": None,
    "hung_while_cooling": "watchdog_reset",
}
SIX_SIGMA_K = 6 * 0.8
"""Of the machine's noise."""
SETTLED_S = 600.0
"""Ten time constants of the cooled block."""


def changed_site(folder: Path, changes: tuple[tuple[str, str], ...]) -> Site:
    text = FABRICATOR.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    spec = load_text(text, "changed.yaml")
    return Site(spec.controller, Elf(built(spec, folder)), "nozzle")


@pytest.fixture(scope="module")
def held_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return changed_site(tmp_path_factory.mktemp("held"), HELD)


@pytest.mark.parametrize(("name", "rule"), RULES.items())
def test_a_cooler_with_minimum_times(held_site: Site, name: str, rule: str | None) -> None:
    faults = {each.id: each for each in catalogue(held_site.controller, held_site.program)}
    result = try_fault(faults[name])
    assert (result.detail, result.rule) == ("", rule)


def test_a_fire_reaches_a_loop_that_cools_from_its_start_on(tmp_path: Path) -> None:
    site = changed_site(tmp_path, (("starts: disabled", "starts: enabled"),))
    faults = {each.id: each for each in catalogue(site.controller, site.program)}
    result = try_fault(faults["fire"])
    assert (result.detail, result.rule) == ("", "over_temperature")


def test_a_switch_that_conducts_for_ever_is_cooled_to_where_it_burns_nothing(
    fabricator_site: Site,
) -> None:
    world = starts.heating(fabricator_site)
    world.wiring.heat["heater"] = shorted
    world.switch(on=False)
    world.until(lambda now: now.fault != 0, 10.0)
    world.run(SETTLED_S)
    ambient_c = starts.ambient_c(fabricator_site)
    cooled_c, uncooled_c = (
        steady_c(fabricator_site, 1.0, ambient_c=ambient_c, cooled=cooled)
        for cooled in (True, False)
    )
    assert world.sensed_c == pytest.approx(cooled_c, abs=SIX_SIGMA_K)
    assert cooled_c < fabricator_site.loop.protection.maximum_c < uncooled_c
