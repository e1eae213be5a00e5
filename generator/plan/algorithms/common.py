"""The result of every algorithm's plan, and constants that several algorithms share."""

from collections.abc import Collection
from dataclasses import dataclass

from heatwright.generator.plan.numbers import filter_share, quantity, told_period
from heatwright.generator.plan.parts import Constant, Told
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, OnOff, ThreePosition, facts_of

LEAST_SLOPE_K_PER_S = 1e-9


@dataclass(frozen=True, slots=True)
class AlgorithmPlan:
    """One algorithm in one loop: its template, the values for it, and its constants."""

    template: str
    told: Told
    constants: tuple[Constant, ...]
    full_duty: Constant
    """The duty that the rule heating_failed takes for full power, %."""


@dataclass(frozen=True, slots=True)
class SwitchNames:
    """The values for a switching algorithm.

    lead, hysteresis -- their texts for comments, empty if the algorithm has none; in_use -- their C
    names; inside -- C expression of the error at which an output that is on goes off, K.
    """

    where: str
    lead: str
    hysteresis: str
    in_use: dict[str, str]
    inside: str = ""


def period(source: Source, name: str, loop: Loop) -> Constant:
    """The period of a loop, s."""
    return source.at("period").number(name, loop.period_s, told_period(loop))


def per_period(source: Source, prefix: str, loop: Loop) -> Constant:
    """1/period: converts a change in K to a slope in K/s."""
    return source.at("period").number(
        f"{prefix}_PER_PERIOD", 1.0 / loop.period_s, f"1 / {told_period(loop)}"
    )


def per_step(source: Source, name: str, rate: float, unit: str, loop: Loop) -> Constant:
    """The change in one control period at this rate; its unit is that of the rate, times s."""
    return source.number(
        name, rate * loop.period_s, f"{quantity(rate, unit)} x {told_period(loop)}"
    )


def filter_weight(source: Source, name: str, filter_s: float, loop: Loop) -> Constant:
    """Weight of the newest value in a first-order low pass."""
    return source.number(
        name,
        filter_share(filter_s, loop),
        f"{told_period(loop)} / ({quantity(filter_s, 's')} + {told_period(loop)})",
    )


def least_slope(source: Source, prefix: str) -> Constant:
    """Return the slope below which a decaying slope becomes 0, K/s.

    avr-libc rounds some products below the least normal number differently from IEEE 754.
    """
    return source.number(f"{prefix}_LEAST_SLOPE", LEAST_SLOPE_K_PER_S, "K/s; less becomes 0")


def by_keys(source: Source, name: str) -> frozenset[str]:
    """The names of the algorithm's fields that the keypad can set, for a loop."""
    return frozenset(each.kind.field for each in facts_of(source.controller, name).keyed_numbers)


def in_use(name: str, prefix: str, keyed: Collection[str]) -> dict[str, str]:
    """C names of a switching algorithm's numbers: constants, or variables for `keyed` numbers."""
    return {
        field: f"algorithm_{name}.{field}" if field in keyed else f"{prefix}_{field.upper()}"
        for field in ("hysteresis_k", "lead_s")
    }


def lead_words(algorithm: OnOff | ThreePosition, keyed: Collection[str]) -> str:
    """Text of the algorithm's lead, for a comment; empty without a lead."""
    if "lead_s" in keyed:
        return "a lead"
    return quantity(algorithm.lead_s, "s") if algorithm.lead_s > 0 else ""


def hysteresis_words(algorithm: OnOff | ThreePosition, keyed: Collection[str]) -> str:
    """Text of the algorithm's hysteresis, for a comment; empty without a hysteresis."""
    if "hysteresis_k" in keyed:
        return "a hysteresis"
    return quantity(algorithm.hysteresis_k, "K") if algorithm.hysteresis_k > 0 else ""


def lead_constants(
    source: Source,
    algorithm: OnOff | ThreePosition,
    prefix: str,
    loop: Loop,
    keyed: Collection[str],
) -> list[Constant]:
    """The constants for looking ahead along the slope; none without a lead."""
    if not lead_words(algorithm, keyed):
        return []
    at = source.at("lead_filter")
    return [
        source.at("lead").given(f"{prefix}_LEAD_S", algorithm.lead_s, "s"),
        filter_weight(at, f"{prefix}_RATE_WEIGHT", algorithm.lead_filter_s, loop),
        least_slope(at, prefix),
        per_period(Source(source.spec, source.path[:-1]), prefix, loop),
    ]
