"""On-off control: hysteresis and lead."""

from heatwright.generator.plan.algorithms.common import (
    AlgorithmPlan,
    SwitchNames,
    by_keys,
    hysteresis_words,
    in_use,
    lead_constants,
    lead_words,
)
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, OnOff


def plan(source: Source, name: str, loop: Loop, prefix: str) -> AlgorithmPlan:
    """Plan the algorithm of loop `name`; terms that are zero are left out."""
    algorithm, keyed = loop.algorithm, by_keys(source, name)
    assert isinstance(algorithm, OnOff)  # noqa: S101 - the kind selects this plan
    constants: list[Constant] = []
    hysteresis = hysteresis_words(algorithm, keyed)
    if hysteresis:
        constants.append(
            source.at("hysteresis").given(f"{prefix}_HYSTERESIS_K", algorithm.hysteresis_k, "K")
        )
    constants += lead_constants(source, algorithm, prefix, loop, keyed)
    return AlgorithmPlan(
        template="algorithms/on_off",
        told=SwitchNames(
            source.where, lead_words(algorithm, keyed), hysteresis, in_use(name, prefix, keyed)
        ),
        constants=tuple(constants),
        full_duty=source.number(f"{prefix}_FULL_DUTY_PERCENT", 100.0, "on-off control: 100 %"),
    )
