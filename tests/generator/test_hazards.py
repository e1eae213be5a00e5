"""The README's table of hazards: each rule has its place, and the times are the simulation's."""

import pytest
from rig.specs import EXAMPLES, changed, example, spec_of

from heatwright.generator.plan.protection.hazards import hazards, within
from heatwright.generator.plan.protection.limits import limit
from heatwright.sim.faults import bounds
from heatwright.spec import Loop
from heatwright.spec.breakable import rules_of
from heatwright.spec.rules import RULES

RULES_BY_ID = {rule.id: rule for rule in RULES.values()}
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))


UNCHECKED = ("safety:", "safety:\n  self_checks: false")
TEXTS = {name: changed(name) for name in NAMES} | {
    f"{name} unchecked": changed(name, UNCHECKED) for name in ("chamber", "extruder")
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_each_rule_is_told_for_some_hazard_and_with_what_trips_it(text: str) -> None:
    spec = spec_of(text)
    told = " ".join(row.seen for row in hazards(spec.controller))
    rules = rules_of(spec.controller)
    codes = {f"E{rule.code:02d}" for rule in rules}
    assert {word for word in told.split() if word.startswith("E")} == codes
    assert [rule.id for rule in rules if limit(spec, rule.id) == "not used here"] == []


def bound_s(loop: Loop, rule: str) -> float:
    """Return the bound that `verify` holds a rule to, from the cause to heater off."""
    protection = loop.protection
    if rule.startswith("sensor_") and rule != "sensor_frozen":
        return bounds.answer_s(loop)
    if rule == "heating_failed":
        assert protection.heating is not None
        return bounds.lasting_s(protection.heating.within_s, loop)
    if rule == "runaway_above":
        assert protection.runaway is not None
        return bounds.lasting_s(protection.runaway.for_s, loop)
    return bounds.reading_s(loop)


@pytest.mark.parametrize("name", NAMES)
def test_the_times_are_those_that_verify_holds(name: str) -> None:
    controller = example(name).controller
    for rule in ("sensor_crc", "over_temperature", "rise_rate", "heating_failed", "runaway_above"):
        if RULES_BY_ID[rule] in rules_of(controller):
            slowest_s = max(bound_s(loop, rule) for loop in controller.loops.values())
            assert within(controller, RULES_BY_ID[rule]) == f"{round(slowest_s, 2):g} s", rule
    hangs = f"{bounds.gate_s():g} s, with interrupts off the watchdog's "
    hangs += f"{controller.safety.watchdog_s:g} s"
    assert within(controller, RULES_BY_ID["watchdog_reset"]) == hangs


def test_what_no_rule_sees_is_told() -> None:
    """The chamber has a fan without a proof, and no safety relay."""
    rows = {row.cause: row for row in hazards(example("chamber").controller)}
    assert rows["A fan that a heater needs stands still"].seen == "nothing"
    assert "only the thermal fuse" in rows["A heater's switch conducts permanently"].remains


def test_a_current_beside_a_ds18b20_brings_no_rule_of_what_a_thermometer_on_the_adc_reads() -> None:
    """What its sensor says is judged by the heater: codes 20 to 22."""
    current = ("power: 240 W", "power: 240 W, supply: 24 V, current: {sensor: amps, trip: 15 A}")
    amps = ("\noutputs:", "\n  amps: {kind: current, pin: A2, scale: 0.2 V/A}\n\noutputs:")
    sense = ("sense: {air:", "sense: {amps: {of: heater}, air:")
    text = changed("chamber", amps, current, sense)
    codes = {rule.code for rule in rules_of(spec_of(text).controller)}
    assert {20, 21, 22} <= codes
    assert codes.isdisjoint((17, 18))


@pytest.mark.parametrize(
    ("pulses", "within_s"),
    [
        ("window: 1 s, resolution: 10 ms", 3.04),
        ("window: 1 s, resolution: 10 ms, minimum_on: 100 ms", 3.04),
        ("window: 1 s, resolution: 10 ms, minimum_on: 100 ms, minimum_off: 20 ms", 2.04),
        ("window: 2 s, resolution: 20 ms", 4.04),
        ("window: 2 s, resolution: 20 ms, distribution: spread", 4.04),
    ],
)
def test_a_pin_that_is_held_is_seen_once_three_looks_asked_for_the_other_level(
    pulses: str, within_s: float
) -> None:
    """One that is held on, in the pauses: at nearly full power each window has one of a step."""
    text = changed("kiln", ("window: 1 s, resolution: 10 ms", pulses))
    assert within(spec_of(text).controller, RULES_BY_ID["pin_held"]) == f"{within_s} s"
