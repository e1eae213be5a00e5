"""The values for the templates of a loop: facts, places in the spec, and names in C."""

from dataclasses import dataclass, fields

from heatwright.generator.plan.algorithms.pid import LimitsInForce
from heatwright.generator.plan.loop import adjusted
from heatwright.generator.plan.loop.adjusted import NumberNames
from heatwright.generator.plan.sensors.common import raw_type
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, LoopFacts, facts_of
from heatwright.spec.adjusted import GAINS
from heatwright.spec.sensing.max31856 import TYPE_CODES, lowered


def prefix_of(name: str) -> str:
    """Return the prefix of the constants of loop `name`."""
    return f"LOOP_{name.upper()}"


@dataclass(frozen=True, slots=True)
class CodedType:
    """A type of thermocouple, and its code in the settings."""

    letter: str
    code: int


@dataclass(frozen=True, slots=True)
class Types:
    """Types of thermocouple, grouped by their highest allowed temperature."""

    least: CodedType
    """The type with the lowest limit, which also applies to an invalid code."""
    others: list[CodedType]
    whole: list[CodedType]
    """The types that allow the spec's own limit."""
    where: str


@dataclass(frozen=True, slots=True)
class LoopSummary(LoopFacts):
    """The values of a loop for the templates of gate, fault, settings and program."""

    prefix: str
    where: str
    fan_where: str
    cooler_where: str
    numbers: list[NumberNames]
    kept: dict[str, str]
    """Settings of gains and limits that a host or a master can set, and the spec's values in C."""
    types: Types | None


@dataclass(frozen=True, slots=True)
class LoopNames(LoopSummary):
    """All values for the templates of a loop."""

    raw: str
    """C type of the sensor's readings."""
    averaged: bool
    limited: bool
    """True if the heater's current is limited."""
    can_idle: bool
    """True if there are times in which the loop must not heat."""
    idle_call: str
    """C expression that is true while the loop must not heat."""
    warm_within: str
    ready_within: str
    also_where: str
    average_where: str
    checked_where: str
    holds_where: str
    inputs_where: str
    limit_where: str
    limits_where: str
    programs_where: str
    starts_where: str


def summary(source: Source, name: str) -> LoopSummary:
    """Return a loop's values for gate, fault, settings and program."""
    facts = facts_of(source.controller, name)
    return LoopSummary(
        **{each.name: getattr(facts, each.name) for each in fields(facts)},
        prefix=prefix_of(name),
        where=source.at("heater").where,
        fan_where=source.at("fan").where,
        cooler_where=source.at("cooler").where,
        numbers=adjusted.named(source, name, prefix_of(name)),
        kept=_kept(facts, prefix_of(name)),
        types=_types(source, source.controller.loops[name]),
    )


def loop_names(source: Source, name: str, ready_within: str) -> LoopNames:
    """Return the values for the templates of a loop."""
    told = summary(source, name)
    root, heater = Source(source.spec, ()), Source(source.spec, ("outputs", told.heater))
    return LoopNames(
        **{each.name: getattr(told, each.name) for each in fields(told)} | {"where": source.where},
        raw=raw_type(source.controller.thermometers[told.sensor]),
        averaged=told.readings > 1,
        limited=told.current is not None and told.current.limit_a is not None,
        can_idle=told.commanded or told.inputs,
        idle_call="is_idle()" if told.inputs else "is_off()",
        warm_within=f"{told.prefix}_{'READY' if told.hosted else 'WARM'}_WITHIN_K",
        ready_within=ready_within,
        also_where=source.at("also").where,
        average_where=root.at("sensors", told.sensor, "moving_average").where,
        checked_where=root.at("safety", "self_checks").where,
        holds_where=heater.at("minimum_on").where,
        inputs_where=root.at("safety", "inputs").where,
        limit_where=heater.at("current", "limit").where,
        limits_where=source.at("algorithm", "limits_adjustable").where,
        programs_where=root.at("programs", "loop").where,
        starts_where=source.at("starts").where,
    )


def _kept(facts: LoopFacts, prefix: str) -> dict[str, str]:
    gains = {gain: f"{prefix}_{gain.upper()}" for gain in GAINS if facts.tunable}
    limits = LimitsInForce._fields if facts.limits_adjustable else ()
    return gains | {f"{limit}_percent": f"{prefix}_{limit.upper()}" for limit in limits}


def _types(source: Source, loop: Loop) -> Types | None:
    """Return the types of thermocouple by their limits; None if all have the same limit."""
    sensor = source.controller.thermometers[loop.sensor]
    highest = lowered(sensor, loop.setpoint.maximum_c, loop.protection.maximum_c)
    if not highest:
        return None
    coded = {letter: CodedType(letter, TYPE_CODES.index(letter)) for letter in TYPE_CODES}
    least, *others = sorted(highest, key=lambda letter: (highest[letter], letter))
    return Types(
        least=coded[least],
        others=[coded[letter] for letter in others],
        whole=[coded[letter] for letter in sorted(set(sensor.selectable) - highest.keys())],
        where=Source(source.spec, ("sensors", loop.sensor, "selectable")).where,
    )
