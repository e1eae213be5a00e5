"""A control loop: its step, its protections, its algorithm."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module

from heatwright.generator.plan.algorithms.common import AlgorithmPlan, period
from heatwright.generator.plan.algorithms.pid import in_force
from heatwright.generator.plan.core import permits
from heatwright.generator.plan.loop import adjusted, autotune
from heatwright.generator.plan.loop.current import plan_current
from heatwright.generator.plan.loop.features import FEATURES
from heatwright.generator.plan.loop.names import LoopNames, loop_names, prefix_of
from heatwright.generator.plan.loop.steps import put_together
from heatwright.generator.plan.numbers import quantity, told_period
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, pair
from heatwright.generator.plan.protection.guard import EffortNames, effort_names, guard_constants
from heatwright.generator.plan.protection.monitors import plan_monitors
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, Loop, facts_of
from heatwright.spec.loops import Response
from heatwright.spec.registry import module_of
from heatwright.spec.sensing.max31856 import lowered

FULL_PERCENT = 100.0

RULES_OF_LOOP = (
    "maximum_adjustable", "rise_rate", "runaway", "heating", "frozen", "rising_while_off",
    "effort", "master_lost_after", "on_for_at_most", "agreement",
)  # fmt: skip
"""The keys of `protection` whose places guard.c names."""

READY_WITHIN_K = 1.0
"""Default of `ready_within`: the window of Marlin's `M109` (TEMP_WINDOW)."""

RARE_S = 1.0
"""Longest period with which the display may show a fault only after a step."""


def told_between_steps(controller: Controller, loop: Loop) -> bool:
    """Return whether the display must show a fault, or its end, before the loop's next step.

    It must if something else finds or acknowledges faults, or if the steps are rare.
    """
    facts = facts_of(controller)
    others = facts.gcode, facts.modbus, facts.nextion
    return len(controller.loops) > 1 or any(others) or loop.periods_in(RARE_S) < 1


@dataclass(frozen=True, slots=True)
class GuardNames:
    """Further values for the templates of a loop's protections."""

    where: str
    where_of: dict[str, str]
    t: str
    """C expression of the temperature that the rules use."""
    runaway: bool
    runaway_below: bool
    heating: bool
    full: str
    """C expression of the duty that is full power."""
    swing: str
    other_full: bool
    """True if full power in a tuning is a lower duty, `swing`."""
    frozen: bool
    holding: bool
    rising: bool
    effort: EffortNames | None


@dataclass(frozen=True, slots=True)
class TuningNames:
    """Further values for the templates of the experiment."""

    where: str
    band: bool
    swing: str
    start: str


@dataclass(frozen=True, slots=True)
class ResponseNames:
    """Further values for the templates of the response."""

    where: str
    within_where: str
    for_where: str


def plan_loop(source: Source, name: str, loop: Loop) -> Part:
    """Plan everything of one loop except its sensor and its heater."""
    prefix = prefix_of(name)
    kind = import_module(module_of("algorithm", "plan", loop.algorithm.kind))
    algorithm: AlgorithmPlan = kind.plan(source.at("algorithm"), name, loop, prefix)
    told = loop_names(source, name, quantity(_ready_within_k(loop), "K"))
    measured = plan_current(source, name, loop)
    monitored = plan_monitors(Source(source.spec, ()), name, loop)
    constants = (
        *_loop_constants(source, loop, told),
        *_types_constants(source, loop, prefix),
        *(_average(source, told) if told.averaged else ()),
        *_nearness(source, loop, told),
        *permits(source, loop, prefix),
        *algorithm.constants,
        *adjusted.range_constants(source, name, prefix),
        *(autotune.constants(source, loop, prefix) if told.autotune else ()),
        *(_response(source, loop.response, loop, prefix) if loop.response else ()),
        *guard_constants(source.at("protection"), loop, prefix, algorithm.full_duty),
    )
    return Part(
        files=(
            *measured.files,
            *monitored.files,
            *_files(source, told, algorithm),
            *((File("src/mode.h", "loop/mode.h"),) if told.tunable else ()),
            *((File("src/state.h", "loop/state.h"),) if told.has_state else ()),
        ),
        groups=(Group(f"Loop {name}", constants), *measured.groups, *monitored.groups),
        start_calls=(
            *monitored.start_calls,
            Call(Stage.SENSE, f"guard_{name}.h", f"guard_{name}_reset();"),
            Call(Stage.CONTROL, f"loop_{name}.h", f"loop_{name}_start();"),
        ),
        tick_calls=(Call(Stage.CONTROL, f"loop_{name}.h", f"loop_{name}_tick();"),),
    )


def _files(source: Source, told: LoopNames, algorithm: AlgorithmPlan) -> Iterator[File]:
    """List header and source of the step, and of each of its parts that has files of its own."""
    loop, name = source.controller.loops[told.name], told.name
    step = put_together(told, FEATURES)
    yield File(f"src/loop_{name}.h", "loop/loop.h.j2", told)
    yield File(f"src/loop_{name}.c", "loop/loop.c.j2", (told, step, step.named))
    guard = (told, _guard_names(source, loop, told))
    yield from pair(f"guard_{name}", "protection/guard", guard, key=("protection",))
    own = (told, algorithm.told)
    yield from pair(f"algorithm_{name}", algorithm.template, own, key=("algorithm",))
    if told.autotune:
        swing, start = autotune.names_in_force(loop.algorithm, told.prefix, f"loop_{name}")
        where, band = source.at("autotune").where, math.isfinite(loop.algorithm.on_at_k)
        tuning = (told, TuningNames(where, band, swing, start))
        yield from pair(f"autotune_{name}", "algorithms/autotune", tuning, key=("autotune",))
    if told.response:
        at = source.at("response")
        response = ResponseNames(at.where, at.at("within").where, at.at("for").where)
        yield from pair(f"response_{name}", "loop/response", (told, response), key=("response",))


def _guard_names(source: Source, loop: Loop, told: LoopNames) -> GuardNames:
    at, rules, state = source.at("protection"), loop.protection, f"loop_{told.name}"
    swing = autotune.names_in_force(loop.algorithm, told.prefix, state).swing
    experiment = loop.autotune if told.autotune else None
    return GuardNames(
        where=at.where,
        where_of={rule: at.at(rule).where for rule in RULES_OF_LOOP},
        t=f"{state}.{'reading_c' if told.averaged else 'temperature_c'}",
        runaway=rules.runaway is not None,
        runaway_below=rules.runaway is not None and rules.runaway.below_k is not None,
        heating=rules.heating is not None,
        full=_full_duty(loop, told.name, told.prefix),
        swing=swing if loop.algorithm.tunable else "",
        other_full=experiment is not None and experiment.swing_percent < FULL_PERCENT,
        frozen=rules.frozen is not None,
        holding=bool(rules.frozen and rules.frozen.holding_percent),
        rising=rules.rising_while_off is not None,
        effort=effort_names(loop, told.prefix),
    )


def _full_duty(loop: Loop, name: str, prefix: str) -> str:
    """Return the C expression of the duty that is full power."""
    if loop.algorithm.limits_adjustable:
        return in_force(loop.algorithm, prefix, f"loop_{name}").output_maximum
    return f"{prefix}_FULL_DUTY_PERCENT"


def _response(source: Source, response: Response, loop: Loop, prefix: str) -> list[Constant]:
    """Return the constants that define when a response has settled."""
    at = source.at("response")
    return [
        at.at("within").given(f"{prefix}_RESPONSE_WITHIN_K", response.within_k, "K"),
        at.at("for").steps(f"{prefix}_RESPONSE_STEPS", response.for_s, loop),
        period(source, f"{prefix}_RESPONSE_PERIOD_S", loop),
    ]


def _loop_constants(source: Source, loop: Loop, told: LoopNames) -> list[Constant]:
    """Period and setpoints; bounds only if a command or a stored value could exceed them."""
    bounded = told.commanded or told.adjustable or told.keyed or told.stored
    setpoint = source.at("setpoint")
    bounds = (("minimum", loop.setpoint.minimum_c), ("maximum", loop.setpoint.maximum_c))
    return [
        source.at("period").count(
            f"{told.prefix}_PERIOD_TICKS", loop.period_ticks, told_period(loop)
        ),
        *(
            setpoint.at(key).given(f"{told.prefix}_SETPOINT_{key.upper()}_C", value, "degC")
            for key, value in (("initial", loop.setpoint.initial_c), *(bounds if bounded else ()))
        ),
    ]


def _types_constants(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    """Highest setpoint and maximum for each thermocouple type with lower limits than the spec's."""
    sensor = source.controller.sensors[loop.sensor]
    setpoint_c, maximum_c = loop.setpoint.maximum_c, loop.protection.maximum_c
    at = Source(source.spec, ("sensors", loop.sensor, "selectable"))
    constants = []
    for letter, highest_c in lowered(sensor, setpoint_c, maximum_c).items():
        hottest_c = highest_c + (maximum_c - setpoint_c)
        constants += [
            at.number(f"{prefix}_SETPOINT_MAXIMUM_{letter}_C", highest_c, f"a type {letter}"),
            at.number(f"{prefix}_MAXIMUM_{letter}_C", hottest_c, "as far above it as the spec's"),
        ]
    return constants


def _average(source: Source, told: LoopNames) -> list[Constant]:
    """Constants of the moving average that the control uses."""
    at = Source(source.spec, ("sensors", told.sensor, "moving_average"))
    return [
        at.count(f"{told.prefix}_READINGS", told.readings, "in the mean that the control uses"),
        at.number(f"{told.prefix}_SHARE", 1.0 / told.readings, f"1 / {told.readings}"),
    ]


def _ready_within_k(loop: Loop) -> float:
    return READY_WITHIN_K if loop.ready_within_k is None else loop.ready_within_k


def _nearness(source: Source, loop: Loop, told: LoopNames) -> list[Constant]:
    """The deviation within which a loop is ready for its host, or its state is "warm", K."""
    if not told.hosted and not told.has_state:
        return []
    at, within_k = source.at("ready_within"), _ready_within_k(loop)
    if not told.hosted and loop.algorithm.warm_within_k is not None:
        at, within_k = source.at("algorithm", "dead_band"), loop.algorithm.warm_within_k
    return [at.given(told.warm_within, within_k, "K")]
