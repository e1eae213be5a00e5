"""A control loop: its step, its protections, its algorithm."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from heatwright.generator.plan import adjusted, autotune
from heatwright.generator.plan.algorithms.common import AlgorithmPlan
from heatwright.generator.plan.algorithms.pid import in_force
from heatwright.generator.plan.core import permits
from heatwright.generator.plan.current import current_of, plan_current
from heatwright.generator.plan.numbers import quantity, steps, ticks
from heatwright.generator.plan.outputs.common import stops
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage
from heatwright.generator.plan.protection import relay
from heatwright.generator.plan.protection.guard import effort_context, guard_constants
from heatwright.generator.plan.protection.monitors import plan_monitors
from heatwright.generator.plan.sensors.common import raw_type
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, Loop, monitors_of, proofs, proven_in
from heatwright.spec.commands import (
    commanded,
    countdown_of,
    limits_adjustable,
    must_release,
    programmed,
    starts_enabled,
    switched,
    tunable,
)
from heatwright.spec.indicated import indicated
from heatwright.spec.inputs import tripping
from heatwright.spec.loops import Response
from heatwright.spec.registry import module_of
from heatwright.spec.self_checks import self_checked
from heatwright.spec.sensing.max31856 import TYPE_CODES, lowered

FULL_PERCENT = 100.0

RULES_OF_LOOP = (
    "maximum_adjustable", "rise_rate", "runaway", "heating", "frozen", "rising_while_off",
    "effort", "master_lost_after", "on_for_at_most", "agreement",
)  # fmt: skip
"""The keys of `protection` that guard.c names."""

READY_WITHIN_K = 1.0
"""Where the spec does not say it: what Marlin's `M109` waits for (TEMP_WINDOW)."""


RARE_S = 1.0
"""A loop's step shows what is latched; with longer steps the display does not wait for it."""


def prefix_of(name: str) -> str:
    """Begin the constants of loop `name` with this."""
    return f"LOOP_{name.upper()}"


def steps_are_rare(loop: Loop) -> bool:
    """Tell whether a fault that another part finds is shown before the loop's next step."""
    return loop.period_s > RARE_S


def summary(source: Source, name: str) -> dict[str, object]:
    """Say what gate, fault and settings need to know of each loop."""
    controller = source.controller
    loop = controller.loops[name]
    by_host, by_master = _hosted(controller, name), switched(controller, name)
    by_gain = tunable(controller, name)
    return {
        "name": name,
        "prefix": prefix_of(name),
        "heater": loop.heater,
        "fan": loop.fan,
        "where": source.at("heater").where,
        "fan_where": source.at("fan").where,
        "fan_proven": loop.fan in proofs(controller),
        "cooler": loop.cooler,
        "cooler_where": source.at("cooler").where,
        "stored": loop.setpoint.stored,
        "commanded": by_host or by_master,
        "hosted": by_host,
        "switched": by_master,
        "tunable": by_gain,
        "lasting": by_host and by_gain and loop.setpoint.stored,
        "programmed": programmed(controller, name),
        "must_release": by_master and must_release(controller),
        "adjustable": loop.protection.maximum_adjustable,
        "numbers": adjusted.named(source, name, prefix_of(name)),
        "limits_adjustable": limits_adjustable(controller, name),
        "types": _types(source, loop),
    }


def _types(source: Source, loop: Loop) -> dict[str, object] | None:
    """Tell the types of thermocouple apart by what they bear; None if all bear the same."""
    sensor = source.controller.thermometers[loop.sensor]
    highest = lowered(sensor, loop.setpoint.maximum_c, loop.protection.maximum_c)
    if not highest:
        return None
    coded = {letter: {"letter": letter, "code": TYPE_CODES.index(letter)} for letter in TYPE_CODES}
    least, *others = sorted(highest, key=lambda letter: (highest[letter], letter))
    whole = sorted(set(sensor.selectable) - highest.keys())
    return {
        "least": coded[least],
        "others": [coded[letter] for letter in others],
        "whole": [coded[letter] for letter in whole],
        "where": Source(source.spec, ("sensors", loop.sensor, "selectable")).where,
    }


def plan_loop(source: Source, name: str, loop: Loop, *, plotted: bool, shown: bool) -> Part:
    """Plan everything of one loop but its sensor and its heater."""
    prefix = prefix_of(name)
    kind = import_module(module_of("algorithm", "plan", loop.algorithm.kind))
    algorithm = kind.plan(source.at("algorithm"), name, loop, prefix)
    told = switched(source.controller, name) or indicated(source.controller, name)
    by_host = _hosted(source.controller, name)
    experiment = loop.autotune if tunable(source.controller, name) else None
    current = current_of(loop, source)
    heater = Source(source.spec, ("outputs", loop.heater))
    readings = source.controller.thermometers[loop.sensor].moving_average
    context = {
        **summary(source, name),
        "name": name,
        "NAME": name.upper(),
        "prefix": prefix,
        "where": source.where,
        "sensor": loop.sensor,
        "SENSOR": loop.sensor.upper(),
        "raw": raw_type(source.controller.thermometers[loop.sensor]),
        "heater": loop.heater,
        "plotter": plotted,
        "relay_judged": relay.is_judged_by(source.controller, name),
        "proven": proven_in(source.controller, name),
        "idle": "is_idle()" if source.controller.safety.inputs else "is_off()",
        "inputs": bool(source.controller.safety.inputs),
        "inputs_where": Source(source.spec, ("safety", "inputs")).where,
        "inputs_judged": bool(tripping(source.controller))
        and name == next(iter(source.controller.loops)),
        "also": loop.also,
        "also_where": source.at("also").where,
        "monitors": [each for each in monitors_of(source.controller, name) if each != loop.also],
        "wanting": name in relay.wanting(source.controller),
        "panel": shown,
        "countdown": countdown_of(source.controller, name) is not None,
        "readings": readings,
        "averaged": readings > 1,
        "average_where": Source(source.spec, ("sensors", loop.sensor, "moving_average")).where,
        "programs_where": Source(source.spec, ("programs", "loop")).where,
        "starts_enabled": starts_enabled(source.controller, name),
        "starts_where": source.at("starts").where,
        "told": told,
        "master_lost": loop.protection.master_lost_after_s is not None,
        "on_limited": loop.protection.on_for_at_most_s is not None,
        "warm_within": f"{prefix}_{'READY' if by_host else 'WARM'}_WITHIN_K",
        "autotune": experiment is not None,
        "limits_where": source.at("algorithm", "limits_adjustable").where,
        "ready_within": quantity(_ready_within_k(loop), "K"),
        "current": current is not None,
        "limited": current is not None and current.limit_a is not None,
        "limit_where": heater.at("current", "limit").where,
        "response": loop.response is not None,
        "heater_holds": stops(source.controller, loop.heater),
        "holds_where": heater.at("minimum_on").where,
        "checked": self_checked(source.controller),
        "checked_where": Source(source.spec, ("safety", "self_checks")).where,
    }
    guard = {
        **context,
        "where": source.at("protection").where,
        "where_of": {rule: source.at("protection", rule).where for rule in RULES_OF_LOOP},
        "t": f"loop_{name}.{'reading_c' if readings > 1 else 'temperature_c'}",
        "runaway": loop.protection.runaway is not None,
        "runaway_below": loop.protection.runaway is not None
        and loop.protection.runaway.below_k is not None,
        "heating": loop.protection.heating is not None,
        "full": _full_duty(loop, name, prefix),
        "swing": _in_tuning(loop, name, prefix)["swing"],
        "other_full": experiment is not None and experiment.swing_percent < FULL_PERCENT,
        "frozen": loop.protection.frozen is not None,
        "holding": bool(loop.protection.frozen and loop.protection.frozen.holding_percent),
        "rising": loop.protection.rising_while_off is not None,
        "effort": effort_context(loop, prefix),
    }
    bounded = bool(context["commanded"] or context["adjustable"]) or shown or loop.setpoint.stored
    constants = (
        *_loop_constants(source, loop, prefix, bounded=bounded),
        *_types_constants(source, loop, prefix),
        *(_average(source, prefix, loop.sensor, readings) if readings > 1 else ()),
        *(_readiness(source, loop, prefix) if by_host else ()),
        *(_warmth(source, loop, prefix) if told and not by_host else ()),
        *permits(source, loop, prefix),
        *algorithm.constants,
        *adjusted.range_constants(source, name, prefix),
        *(autotune.constants(source, loop, prefix) if experiment is not None else ()),
        *(_response(source, loop.response, loop.period_s, prefix) if loop.response else ()),
        *guard_constants(source.at("protection"), loop, prefix, algorithm.full_duty),
    )
    measured = plan_current(source, name, loop)
    monitored = plan_monitors(Source(source.spec, ()), name, loop)
    return Part(
        files=(
            *measured.files,
            *monitored.files,
            File(f"src/loop_{name}.h", "src/loop.h.j2", context),
            File(f"src/loop_{name}.c", "src/loop.c.j2", context),
            File(f"src/guard_{name}.h", "src/guard.h.j2", guard, ("protection",)),
            File(f"src/guard_{name}.c", "src/guard.c.j2", guard, ("protection",)),
            *_algorithm_files(name, algorithm, context),
            *(_tuning_files(source, name, algorithm, context) if experiment is not None else ()),
            *(_response_files(source, name, context) if loop.response is not None else ()),
            *((File("src/mode.h", "src/mode.h"),) if context["tunable"] else ()),
            *((File("src/state.h", "src/state.h"),) if told else ()),
        ),
        groups=(Group(f"Loop {name}", constants), *measured.groups, *monitored.groups),
        start_calls=(
            *monitored.start_calls,
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
        File(
            f"src/algorithm_{name}.{end}", f"{algorithm.template}.{end}.j2", merged, ("algorithm",)
        )
        for end in ("h", "c")
    )


def _tuning_files(
    source: Source, name: str, algorithm: AlgorithmPlan, context: dict[str, Any]
) -> tuple[File, ...]:
    merged = {
        **context, "where": source.at("autotune").where, "band": algorithm.context["band"],
        **_in_tuning(source.controller.loops[name], name, str(context["prefix"])),
    }  # fmt: skip
    return tuple(
        File(f"src/autotune_{name}.{end}", f"algorithms/autotune.{end}.j2", merged, ("autotune",))
        for end in ("h", "c")
    )


def _full_duty(loop: Loop, name: str, prefix: str) -> str:
    """Name the duty that is full power in C."""
    if loop.algorithm.pid and loop.algorithm.limits_adjustable:
        return in_force(loop.algorithm.pid, prefix, f"loop_{name}").output_maximum
    return f"{prefix}_FULL_DUTY_PERCENT"


def _in_tuning(loop: Loop, name: str, prefix: str) -> dict[str, str]:
    """Name what a tuning goes by in C; an algorithm without gains has none."""
    if loop.algorithm.pid is None:
        return {"swing": ""}
    return autotune.names_in_force(loop.algorithm.pid, prefix, f"loop_{name}")


def _response_files(source: Source, name: str, context: dict[str, Any]) -> tuple[File, ...]:
    at = source.at("response")
    merged = {
        **context,
        "where": at.where,
        "within_where": at.at("within").where,
        "for_where": at.at("for").where,
    }
    return tuple(
        File(f"src/response_{name}.{end}", f"src/response.{end}.j2", merged, ("response",))
        for end in ("h", "c")
    )


def _response(source: Source, response: Response, period_s: float, prefix: str) -> list[Constant]:
    """What counts as settled."""
    at = source.at("response")
    return [
        at.at("within").number(
            f"{prefix}_RESPONSE_WITHIN_K", response.within_k, quantity(response.within_k, "K")
        ),
        at.at("for").count(
            f"{prefix}_RESPONSE_STEPS",
            steps(response.for_s, period_s),
            f"{quantity(response.for_s, 's')} in periods of {quantity(period_s, 's')}",
        ),
        source.at("period").number(
            f"{prefix}_RESPONSE_PERIOD_S", period_s, quantity(period_s, "s")
        ),
    ]


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


def _types_constants(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    """What is asked for, and borne, at most while a type is chosen that bears less."""
    sensor = source.controller.sensors[loop.sensor]
    setpoint_c, maximum_c = loop.setpoint.maximum_c, loop.protection.maximum_c
    at = Source(source.spec, ("sensors", loop.sensor, "selectable"))
    constants = []
    for letter, highest_c in lowered(sensor, setpoint_c, maximum_c).items():
        hottest_c = highest_c + (maximum_c - setpoint_c)
        constants += [
            at.number(f"{prefix}_SETPOINT_MAXIMUM_{letter}_C", highest_c, f"a type {letter}"),
            at.number(f"{prefix}_MAXIMUM_{letter}_C", hottest_c, "as far above it as ever"),
        ]
    return constants


def _average(source: Source, prefix: str, sensor: str, readings: int) -> list[Constant]:
    """How many readings are in the mean that the loop goes by."""
    at = Source(source.spec, ("sensors", sensor, "moving_average"))
    return [
        at.count(f"{prefix}_READINGS", readings, "whose mean the control goes by"),
        at.number(f"{prefix}_SHARE", 1.0 / readings, f"1 / {readings}"),
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


def _warmth(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    """How near to the setpoint is warm, where no host asks whether the loop is ready."""
    at, within_k = source.at("algorithm", "dead_band"), loop.algorithm.warm_within_k
    if within_k is None:
        at, within_k = source.at("ready_within"), _ready_within_k(loop)
    return [at.number(f"{prefix}_WARM_WITHIN_K", within_k, quantity(within_k, "K"))]


def _hosted(controller: Controller, name: str) -> bool:
    """Tell whether a host commands a loop by its setpoint alone, 0 for off."""
    return commanded(controller, name) and not switched(controller, name)
