"""On-off control: hysteresis and lead."""

from __future__ import annotations

from heatwright.generator.plan.algorithms.common import AlgorithmPlan, filter_weight, per_period
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, OnOff


def plan(source: Source, name: str, loop: Loop, prefix: str) -> AlgorithmPlan:
    """Plan the algorithm of loop `name`; terms that are zero are left out."""
    del name
    algorithm = loop.algorithm
    assert isinstance(algorithm, OnOff)  # noqa: S101 - found by its kind
    constants: list[Constant] = []
    if algorithm.hysteresis_k > 0:
        constants.append(
            source.at("hysteresis").number(
                f"{prefix}_HYSTERESIS_K",
                algorithm.hysteresis_k,
                quantity(algorithm.hysteresis_k, "K"),
            )
        )
    if algorithm.lead_s > 0:
        constants += [
            source.at("lead").number(
                f"{prefix}_LEAD_S", algorithm.lead_s, quantity(algorithm.lead_s, "s")
            ),
            filter_weight(
                source.at("lead_filter"),
                f"{prefix}_RATE_WEIGHT",
                algorithm.lead_filter_s,
                loop.period_s,
            ),
            per_period(Source(source.spec, source.path[:-1]), prefix, loop.period_s),
        ]
    return AlgorithmPlan(
        template="algorithms/on_off",
        context={
            "where": source.where,
            "lead": quantity(algorithm.lead_s, "s") if algorithm.lead_s > 0 else "",
            "hysteresis": algorithm.hysteresis_k > 0,
        },
        constants=tuple(constants),
        full_duty=source.number(f"{prefix}_FULL_DUTY_PERCENT", 100.0, "on-off control: 100 %"),
    )
