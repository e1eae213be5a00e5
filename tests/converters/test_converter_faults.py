"""Each fault of a converter and its thermocouple, on the firmware's binary."""

from functools import cache

import pytest
from rig.avr import whole
from rig.chips import KINDS, crucible
from rig.specs import spec_of

from heatwright.sim.faults import Fault, catalogue, try_fault

OF_BOTH = {
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
OWN = {
    "max6675": OF_BOTH,
    "max31855": OF_BOTH
    | {
        "thermocouple_touches_ground": "sensor_short",
        "thermocouple_touches_supply": "sensor_short",
        "slow_conversions": None,
    },
}
"""In the catalogue's order, and the rule that each trips; a MAX31856's are in tests/faults."""
EACH = [(kind, name, rule) for kind, own in OWN.items() for name, rule in own.items()]


@cache
def faults(kind: str) -> dict[str, Fault]:
    text = crucible(kind)
    return {fault.id: fault for fault in catalogue(spec_of(text).controller, whole(text))}


@pytest.mark.parametrize(("kind", "name", "rule"), EACH)
def test_its_own_faults(kind: str, name: str, rule: str | None) -> None:
    result = try_fault(faults(kind)[name])
    assert result.detail == ""
    assert result.rule == rule


@pytest.mark.parametrize("kind", OWN)
def test_they_come_first_in_the_catalogue(kind: str) -> None:
    assert list(faults(kind))[: len(OWN[kind])] == list(OWN[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_what_any_sensor_can_suffer(kind: str) -> None:
    """All other faults of the catalogue: tips, heaters, memory, processor, healthy machines."""
    own = OWN.get(kind, {})
    others = [fault for name, fault in faults(kind).items() if name not in own]
    results = [try_fault(fault) for fault in others]
    assert any(result.fault.startswith("healthy") for result in results)
    assert {result.fault: result.detail for result in results if not result.passed} == {}
