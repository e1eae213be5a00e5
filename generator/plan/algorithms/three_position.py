"""Three-position control: a dead band, with hysteresis and lead."""

from collections.abc import Collection

from heatwright.generator.plan.algorithms.common import (
    AlgorithmPlan,
    SwitchNames,
    by_keys,
    hysteresis_words,
    in_use,
    lead_constants,
    lead_words,
)
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, ThreePosition


def plan(source: Source, name: str, loop: Loop, prefix: str) -> AlgorithmPlan:
    """Plan the algorithm of loop `name`; terms that are zero are left out."""
    algorithm, keyed = loop.algorithm, by_keys(source, name)
    assert isinstance(algorithm, ThreePosition)  # noqa: S101 - the kind selects this plan
    return AlgorithmPlan(
        template="algorithms/three_position",
        told=SwitchNames(
            source.where,
            lead_words(algorithm, keyed),
            hysteresis_words(algorithm, keyed),
            in_use(name, prefix, keyed),
            f"({prefix}_DEAD_BAND_K - algorithm_{name}.hysteresis_k)"
            if "hysteresis_k" in keyed
            else f"{prefix}_INSIDE_K",
        ),
        constants=(
            *_band(source, algorithm, prefix, keyed),
            *lead_constants(source, algorithm, prefix, loop, keyed),
        ),
        full_duty=source.number(
            f"{prefix}_FULL_DUTY_PERCENT", 100.0, "three-position control: 100 %"
        ),
    )


def _band(
    source: Source, algorithm: ThreePosition, prefix: str, keyed: Collection[str]
) -> list[Constant]:
    band_k, hysteresis_k = algorithm.dead_band_k, algorithm.hysteresis_k
    constants = [source.at("dead_band").given(f"{prefix}_DEAD_BAND_K", band_k, "K")]
    at, words = source.at("hysteresis"), f"{quantity(band_k, 'K')} - {quantity(hysteresis_k, 'K')}"
    if "hysteresis_k" in keyed:
        constants.append(at.given(f"{prefix}_HYSTERESIS_K", hysteresis_k, "K"))
    elif hysteresis_k > 0:
        constants.append(at.number(f"{prefix}_INSIDE_K", band_k - hysteresis_k, words))
    return constants
