"""Each fault of a converter and its thermocouple, on the binary that PlatformIO built."""

from functools import cache

import pytest
from converter_specs import KINDS, program, spec_of

from heatwright.sim.faults import Fault, catalogue, try_fault
from heatwright.sim.faults.world import Site

WIRES = {
    "unplugged": "sensor_no_answer",
    "data_shorted_to_ground": "sensor_short",
    "data_shorted_to_supply": "sensor_no_answer",
    "no_clock": "sensor_no_answer",
    "damaged_answers": "sensor_crc",
    "thermocouple_broken": "sensor_open",
    "failing_supply": "sensor_no_answer",
    "frozen": "heating_failed",
    "answers_damaged_in_bursts": None,
    "supply_interrupted_once": None,
}
TOUCHES = {
    "thermocouple_touches_ground": "sensor_short",
    "thermocouple_touches_supply": "sensor_short",
    "slow_conversions": None,
}
OWN = {"max6675": WIRES, "max31855": WIRES | TOUCHES}
EACH = [(kind, name, rule) for kind, own in OWN.items() for name, rule in own.items()]


@cache
def faults(kind: str) -> dict[str, Fault]:
    site = Site(spec_of(kind).controller, program(kind), "crucible")
    return {fault.id: fault for fault in catalogue(site.controller, site.program)}


@pytest.mark.parametrize(("kind", "name", "rule"), EACH)
def test_its_own_faults(kind: str, name: str, rule: str | None) -> None:
    result = try_fault(faults(kind)[name])
    assert result.detail == ""
    assert result.rule == rule


@pytest.mark.parametrize("kind", KINDS)
def test_they_come_first_in_the_catalogue(kind: str) -> None:
    assert list(faults(kind))[: len(OWN[kind])] == list(OWN[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_what_any_sensor_can_suffer(kind: str) -> None:
    """All other faults of the catalogue, tips, heaters, memory, processor."""
    others = [fault for name, fault in faults(kind).items() if name not in OWN[kind]]
    results = [try_fault(fault) for fault in others if not fault.id.startswith("healthy")]
    assert {result.fault: result.detail for result in results if not result.passed} == {}


@pytest.mark.parametrize("kind", KINDS)
def test_healthy_machines(kind: str) -> None:
    healthy = [fault for name, fault in faults(kind).items() if name.startswith("healthy")]
    assert healthy
    assert all(try_fault(fault).passed for fault in healthy)
