"""Autotuning: the constants and C names of the relay experiment."""

from typing import NamedTuple

from heatwright.generator.plan.algorithms.pid import in_force
from heatwright.generator.plan.numbers import quantity, told_period
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Autotune, Loop, Pid
from heatwright.spec.algorithms import Algorithm

FILTERS_AND_PERIODS = 1.35
"""Shortest time constant of the closed loop, in multiples of derivative filter plus period
(docs/control.md, "The rule")."""


def constants(loop: Source, spec: Loop, prefix: str) -> list[Constant]:
    """The constants of a loop's experiment."""
    pid, experiment = spec.algorithm.pid, spec.autotune
    assert pid is not None  # noqa: S101 - autotune needs a pid
    assert experiment is not None  # noqa: S101 - the caller has looked
    return [
        *_experiment(loop.at("autotune"), experiment, pid, prefix, spec),
        *_rule(loop.at("algorithm"), pid, prefix, spec),
    ]


def swing_percent(experiment: Autotune, pid: Pid) -> float:
    """Duty while the relay is on, %."""
    return pid.output.maximum_percent * experiment.swing_percent / 100


def _experiment(
    source: Source, experiment: Autotune, pid: Pid, prefix: str, loop: Loop
) -> list[Constant]:
    swing = quantity(experiment.swing_percent, "%")
    return [
        source.at("swing").number(
            f"{prefix}_TUNING_SWING_SHARE",
            experiment.swing_percent / 100,
            f"{swing} of the output's maximum in force",
        )
        if pid.limits_adjustable
        else source.at("swing").number(
            f"{prefix}_TUNING_SWING_PERCENT",
            swing_percent(experiment, pid),
            f"{swing} of {quantity(pid.output.maximum_percent, '%')}",
        ),
        source.at("timeout").steps(f"{prefix}_TUNING_TIMEOUT_STEPS", experiment.timeout_s, loop),
    ]


def _rule(source: Source, pid: Pid, prefix: str, loop: Loop) -> list[Constant]:
    filter_s, limits = pid.derivative_filter_s, pid.integral
    shown = quantity(filter_s, "s")
    start = source.at("integral").number(
        f"{prefix}_TUNING_START_PERCENT",
        min(max(0.0, limits.minimum_percent), limits.maximum_percent),
        "initial integral: 0, within its limits",
    )
    return [
        source.at("derivative_filter").number(f"{prefix}_TUNING_FILTER_S", filter_s, shown),
        source.at("derivative_filter").number(
            f"{prefix}_TUNING_LEAST_S",
            FILTERS_AND_PERIODS * (filter_s + loop.period_s),
            f"{FILTERS_AND_PERIODS:g} x ({shown} + {told_period(loop)})",
        ),
        *([] if pid.limits_adjustable else [start]),
    ]


class NamesInForce(NamedTuple):
    """C names of an experiment's numbers: its swing, and the initial integral."""

    swing: str
    start: str


def names_in_force(algorithm: Algorithm, prefix: str, state: str) -> NamesInForce:
    """Name these numbers; `state` is the C name of the loop's state."""
    if not algorithm.limits_adjustable:
        return NamesInForce(f"{prefix}_TUNING_SWING_PERCENT", f"{prefix}_TUNING_START_PERCENT")
    limits = in_force(algorithm, prefix, state)
    return NamesInForce(
        f"({limits.output_maximum} * {prefix}_TUNING_SWING_SHARE)",
        f"limit(0.0f, {limits.integral_minimum}, {limits.integral_maximum})",
    )
