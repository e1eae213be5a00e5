"""PID control: terms with a zero gain are left out."""

from __future__ import annotations

from heatwright.generator.plan.algorithms.common import AlgorithmPlan, filter_weight, per_period
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, Pid


def plan(source: Source, name: str, loop: Loop, prefix: str) -> AlgorithmPlan:
    """Plan the algorithm of loop `name`."""
    del name
    algorithm = loop.algorithm
    assert isinstance(algorithm, Pid)  # noqa: S101 - found by its kind
    constants = [
        source.at("kp").number(f"{prefix}_KP", algorithm.kp, quantity(algorithm.kp, "%/K"))
    ]
    if algorithm.ki > 0:
        constants += _integral(source, algorithm, prefix, loop.period_s)
    if algorithm.kd > 0:
        constants += [
            source.at("kd").number(f"{prefix}_KD", algorithm.kd, quantity(algorithm.kd, "%*s/K")),
            filter_weight(
                source.at("derivative_filter"),
                f"{prefix}_SLOPE_WEIGHT",
                algorithm.derivative_filter_s,
                loop.period_s,
            ),
            per_period(Source(source.spec, source.path[:-1]), prefix, loop.period_s),
        ]
    output = source.at("output")
    maximum = algorithm.output.maximum_percent
    constants += [
        output.at(key).number(f"{prefix}_OUTPUT_{key.upper()}", value, quantity(value, "%"))
        for key, value in (("minimum", algorithm.output.minimum_percent), ("maximum", maximum))
    ]
    return AlgorithmPlan(
        template="algorithms/pid",
        context={
            "where": source.where,
            "where_of": {"kd": source.at("kd").where},
            "integral": algorithm.ki > 0,
            "hold": algorithm.integral.while_limited == "hold",
            "derivative": algorithm.kd > 0,
            "of_error": algorithm.derivative_of == "error",
        },
        constants=tuple(constants),
        full_duty=output.at("maximum").number(
            f"{prefix}_FULL_DUTY_PERCENT", maximum, quantity(maximum, "%")
        ),
    )


def _integral(source: Source, algorithm: Pid, prefix: str, period_s: float) -> list[Constant]:
    limits = source.at("integral")
    return [
        source.at("ki").number(
            f"{prefix}_KI_PER_STEP",
            algorithm.ki * period_s,
            f"{quantity(algorithm.ki, '%/(K*s)')} x {quantity(period_s, 's')}",
        ),
        *(
            limits.at(key).number(f"{prefix}_INTEGRAL_{key.upper()}", value, quantity(value, "%"))
            for key, value in (
                ("minimum", algorithm.integral.minimum_percent),
                ("maximum", algorithm.integral.maximum_percent),
            )
        ),
    ]
