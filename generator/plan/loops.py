"""A control loop: its step, its protections, its algorithm."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from heatwright.generator.plan import autotune
from heatwright.generator.plan.algorithms.common import AlgorithmPlan
from heatwright.generator.plan.core import permits
from heatwright.generator.plan.guard import guard_constants
from heatwright.generator.plan.numbers import quantity, ticks
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop
from heatwright.spec.commands import commanded, tunable

FULL_PERCENT = 100.0

READY_WITHIN_K = 1.0
"""Where the spec does not say it: what Marlin's `M109` waits for (TEMP_WINDOW)."""


def prefix_of(name: str) -> str:
    """Begin the constants of loop `name` with this."""
    return f"LOOP_{name.upper()}"


def summary(source: Source, name: str) -> dict[str, object]:
    """Say what gate, fault and settings need to know of each loop."""
    controller = source.controller
    loop = controller.loops[name]
    return {
        "name": name,
        "prefix": prefix_of(name),
        "heater": loop.heater,
        "fan": loop.fan,
        "where": source.at("heater").where,
        "fan_where": source.at("fan").where,
        "stored": loop.setpoint.stored,
        "commanded": commanded(controller, name),
        "tunable": tunable(controller, name),
    }


def plan_loop(source: Source, name: str, loop: Loop, *, plotted: bool, shown: bool) -> Part:
    """Plan everything of one loop but its sensor and its heater."""
    prefix = prefix_of(name)
    kind = import_module(f"heatwright.generator.plan.algorithms.{loop.algorithm.kind}")
    algorithm = kind.plan(source.at("algorithm"), name, loop, prefix)
    by_host = commanded(source.controller, name)
    experiment = loop.autotune if tunable(source.controller, name) else None
    context = {
        "name": name,
        "NAME": name.upper(),
        "prefix": prefix,
        "where": source.where,
        "sensor": loop.sensor,
        "SENSOR": loop.sensor.upper(),
        "heater": loop.heater,
        "plotter": plotted,
        "panel": shown,
        "commanded": by_host,
        "tunable": tunable(source.controller, name),
        "autotune": experiment is not None,
        "stored": loop.setpoint.stored,
        "ready_within": quantity(_ready_within_k(loop), "K"),
    }
    guard = {
        **context,
        "where": source.at("protection").where,
        "where_of": {
            rule: source.at("protection", rule).where
            for rule in ("rise_rate", "runaway", "heating", "frozen", "rising_while_off")
        },
        "runaway": loop.protection.runaway is not None,
        "runaway_below": loop.protection.runaway is not None
        and loop.protection.runaway.below_k is not None,
        "heating": loop.protection.heating is not None,
        "other_full": experiment is not None and experiment.swing_percent < FULL_PERCENT,
        "frozen": loop.protection.frozen is not None,
        "rising": loop.protection.rising_while_off is not None,
    }
    constants = (
        *_loop_constants(source, loop, prefix, bounded=by_host or shown or loop.setpoint.stored),
        *(_readiness(source, loop, prefix) if by_host else ()),
        *permits(source, loop, prefix),
        *algorithm.constants,
        *(autotune.constants(source, loop, prefix) if experiment is not None else ()),
        *guard_constants(source.at("protection"), loop, prefix, algorithm.full_duty),
    )
    return Part(
        files=(
            File(f"src/loop_{name}.h", "src/loop.h.j2", context),
            File(f"src/loop_{name}.c", "src/loop.c.j2", context),
            File(f"src/guard_{name}.h", "src/guard.h.j2", guard),
            File(f"src/guard_{name}.c", "src/guard.c.j2", guard),
            *_algorithm_files(name, algorithm, context),
            *(_tuning_files(source, name, algorithm, context) if experiment is not None else ()),
            *((File("src/mode.h", "src/mode.h"),) if context["tunable"] else ()),
        ),
        groups=(Group(f"Loop {name}", constants),),
        start_calls=(
            Call(Stage.SENSE, f"guard_{name}.h", f"guard_{name}_reset();"),
            Call(Stage.CONTROL, f"loop_{name}.h", f"loop_{name}_start();"),
        ),
        tick_calls=(Call(Stage.CONTROL, f"loop_{name}.h", f"loop_{name}_tick();"),),
    )


def _algorithm_files(
    name: str, algorithm: AlgorithmPlan, context: dict[str, Any]
) -> tuple[File, ...]:
    merged = {**context, **algorithm.context}
    return tuple(
        File(f"src/algorithm_{name}.{end}", f"{algorithm.template}.{end}.j2", merged)
        for end in ("h", "c")
    )


def _tuning_files(
    source: Source, name: str, algorithm: AlgorithmPlan, context: dict[str, Any]
) -> tuple[File, ...]:
    merged = {
        **context, "where": source.at("autotune").where, "band": algorithm.context["band"],
    }  # fmt: skip
    return tuple(
        File(f"src/autotune_{name}.{end}", f"algorithms/autotune.{end}.j2", merged)
        for end in ("h", "c")
    )


def _loop_constants(source: Source, loop: Loop, prefix: str, *, bounded: bool) -> list[Constant]:
    """Period and setpoints; its bounds only where keys or a stored value could leave them."""
    setpoint = source.at("setpoint")
    bounds = (("minimum", loop.setpoint.minimum_c), ("maximum", loop.setpoint.maximum_c))
    return [
        source.at("period").count(
            f"{prefix}_PERIOD_TICKS", ticks(loop.period_s), quantity(loop.period_s, "s")
        ),
        *(
            setpoint.at(key).number(
                f"{prefix}_SETPOINT_{key.upper()}_C", value, quantity(value, "degC")
            )
            for key, value in (("initial", loop.setpoint.initial_c), *(bounds if bounded else ()))
        ),
    ]


def _ready_within_k(loop: Loop) -> float:
    return READY_WITHIN_K if loop.ready_within_k is None else loop.ready_within_k


def _readiness(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    within_k = _ready_within_k(loop)
    return [
        source.at("ready_within").number(
            f"{prefix}_READY_WITHIN_K", within_k, quantity(within_k, "K")
        )
    ]
