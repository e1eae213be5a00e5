"""Each fault of each kind of analog sensor."""

import pytest
from analog_specs import KEYS, bed
from rig.avr import whole
from rig.specs import spec_of

from heatwright.sim.faults import try_fault
from heatwright.sim.faults.analog import faults
from heatwright.sim.faults.world import Site

RULES = {
    "open": "sensor_open",
    "shorted": "sensor_short",
    "beyond_the_cold_end": "sensor_range",
    "beyond_the_hot_end": "sensor_range",
    "adc_hangs": "sensor_stale",
    "adc_stuck": "heating_failed",
    "intermittent_wire": None,
    "contact_corrodes": "rise_rate",
    "insulation_leaks": "rise_rate",
}
RESISTORS_ONLY = {"contact_corrodes", "insulation_leaks"}


@pytest.fixture(scope="module", params=["hotend", "frost", "falling"])
def site(request: pytest.FixtureRequest) -> Site:
    """One of each kind."""
    text = bed(request.param, interface=KEYS)
    return Site(spec_of(text).controller, whole(text), "bed")


def test_its_faults_are_these(site: Site) -> None:
    own = [fault.id for fault in faults(site)]
    kind = site.controller.sensors["bed"].kind
    assert own == [name for name in RULES if kind != "analog" or name not in RESISTORS_ONLY]


@pytest.mark.parametrize("name", RULES)
def test_the_fault(site: Site, name: str) -> None:
    found = {fault.id: fault for fault in faults(site)}.get(name)
    if found is None:
        assert name in RESISTORS_ONLY
        return
    result = try_fault(found)
    assert result.detail == ""
    assert result.rule == RULES[name]


def test_a_stuck_reading_is_not_heated_for_long(site: Site) -> None:
    """A saturated duty counts as full power, although PID holds its integral there.

    `frozen` alone, with its ten minutes, would let the machine go on far beyond its maximum.
    """
    found = {fault.id: fault for fault in faults(site)}["adc_stuck"]
    result = try_fault(found)
    heating = site.loop.protection.heating
    assert heating is not None
    assert result.rule == "heating_failed"
    assert result.tripped_after_s is not None
    assert result.tripped_after_s <= heating.within_s + 2 * site.loop.period_s + 0.01
