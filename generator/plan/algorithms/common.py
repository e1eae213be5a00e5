"""What every algorithm's plan returns, and the constants several of them share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source


@dataclass(frozen=True, slots=True)
class AlgorithmPlan:
    """Templates, their names, and constants of one algorithm in one loop."""

    template: str
    context: Mapping[str, Any]
    constants: tuple[Constant, ...]
    full_duty: Constant
    """The duty that counts as full heat for the rule heating_failed, %."""


def per_period(loop: Source, prefix: str, period_s: float) -> Constant:
    """1/period: makes a slope in K/s of a change in K."""
    return loop.at("period").number(
        f"{prefix}_PER_PERIOD", 1.0 / period_s, f"1 / {quantity(period_s, 's')}"
    )


def filter_weight(source: Source, name: str, filter_s: float, period_s: float) -> Constant:
    """Weight of the newest value in a first-order low pass: period / (time constant + period)."""
    return source.number(
        name,
        period_s / (filter_s + period_s),
        f"{period_s:g} s / ({quantity(filter_s, 's')} + {period_s:g} s)",
    )
