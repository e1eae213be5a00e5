"""Each fault of a MAX31856 and its thermocouple, on the binary that PlatformIO built."""

from functools import cache

import pytest
from max31856_specs import program, spec_of

from heatwright.sim.faults import Fault, catalogue, try_fault

OWN = {
    "unplugged": "sensor_no_answer",
    "data_shorted_to_ground": "sensor_short",
    "data_shorted_to_supply": "sensor_no_answer",
    "no_clock": "sensor_no_answer",
    "damaged_answers": "sensor_crc",
    "thermocouple_broken": "sensor_open",
    "thermocouple_broken_at_bias": "rise_rate",
    "failing_supply": "sensor_reset",
    "orders_shorted_to_supply": "sensor_no_answer",
    "thermocouple_beyond_supply": "sensor_short",
    "chip_too_hot": "sensor_range",
    "frozen": "heating_failed",
    "answers_damaged_in_bursts": None,
    "supply_interrupted_once": None,
    "slow_conversions": None,
}


@cache
def faults() -> dict[str, Fault]:
    return {fault.id: fault for fault in catalogue(spec_of().controller, program())}


@pytest.mark.parametrize(("name", "rule"), OWN.items())
def test_its_own_faults(name: str, rule: str | None) -> None:
    result = try_fault(faults()[name])
    assert result.detail == ""
    assert result.rule == rule


def test_they_come_first_in_the_catalogue() -> None:
    assert list(faults())[: len(OWN)] == list(OWN)


def test_what_any_sensor_can_suffer() -> None:
    """All other faults of the catalogue: tips, heaters, memory, processor, healthy machines."""
    others = [fault for name, fault in faults().items() if name not in OWN]
    results = [try_fault(fault) for fault in others]
    assert any(result.fault.startswith("healthy") for result in results)
    assert {result.fault: result.detail for result in results if not result.passed} == {}
