"""The program that sets a loop's setpoint: its constants, and its calls in start and step."""

from dataclasses import dataclass

from heatwright.generator.plan.loop.names import LoopSummary
from heatwright.generator.plan.numbers import c_float, told_period
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, pair
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop
from heatwright.spec.programs import Programs

TENTHS_PER_HOUR = 36_000
"""Ten times the seconds in an hour: for rates in tenths of a kelvin per hour."""


def plan(root: Source, loop: LoopSummary) -> Part:
    """Plan program.c; `loop` is the loop whose setpoint the program sets."""
    programs = root.controller.programs
    assert programs is not None  # noqa: S101 - the caller has looked
    source = root.at("programs")
    told = loop, _names(source, programs, loop)
    return Part(
        files=pair("program", "programs/program", told, plain_header=True),
        groups=(Group("Program", tuple(_constants(root, source, programs))),),
        start_calls=(Call(Stage.SENSE, "program.h", "program_start_up();"),),
    )


@dataclass(frozen=True, slots=True)
class ProgramNames:
    """The values for the program's template, in addition to those of its loop."""

    where: str
    averaged: bool
    holds_at_end: bool
    at_end_where: str
    reached_where: str
    hold_back: bool
    hold_back_where: str
    limit_where: str
    power_where: str
    keeps: bool
    fault_where: str
    resumes: bool
    pauses: bool


def _names(source: Source, programs: Programs, loop: LoopSummary) -> ProgramNames:
    power = programs.after_power_loss
    return ProgramNames(
        where=source.where,
        averaged=loop.readings > 1,
        holds_at_end=programs.at_end == "hold",
        at_end_where=source.at("at_end").where,
        reached_where=source.at("reached_within").where,
        hold_back=programs.hold_back is not None,
        hold_back_where=source.at("hold_back").where,
        limit_where=source.at("hold_back", "limit").where,
        power_where=source.at("after_power_loss").where,
        keeps=programs.on_fault == "pause",
        fault_where=source.at("on_fault").where,
        resumes=power.resume_within_k > 0,
        pauses=power.otherwise == "pause",
    )


def _constants(root: Source, source: Source, programs: Programs) -> list[Constant]:
    loop = root.controller.loops[programs.loop]
    period_s, period = loop.period_s, told_period(loop)
    save, reached = source.at("save_every"), source.at("reached_within")
    constants = [
        Constant("PROGRAM_PER_PERIOD", c_float(1.0 / period_s), f"1 / {period}"),
        Constant("PROGRAM_STEPS_PER_S", c_float(1.0 / period_s), f"periods of {period} in 1 s"),
        Constant(
            "PROGRAM_STEPS_TIMES_RATE",
            c_float(TENTHS_PER_HOUR / period_s),
            f"periods of {period} in an hour, for rates of 0.1 K/h",
        ),
        reached.given("PROGRAM_REACHED_K", programs.reached_within_k, "K"),
        save.steps("PROGRAM_SAVE_STEPS", programs.save_every_s, loop),
    ]
    return [*constants, *_hold_back(source, programs, loop), *_resume(source, programs)]


def _hold_back(source: Source, programs: Programs, loop: Loop) -> list[Constant]:
    back = programs.hold_back
    if back is None:
        return []
    return [
        source.at("hold_back").given("PROGRAM_BACK_K", back.within_k, "K"),
        source.at("hold_back", "limit").steps("PROGRAM_LIMIT_STEPS", back.limit_s, loop),
    ]


def _resume(source: Source, programs: Programs) -> list[Constant]:
    within_k = programs.after_power_loss.resume_within_k
    at = source.at("after_power_loss", "resume_within")
    return [at.given("PROGRAM_RESUME_WITHIN_K", within_k, "K")] if within_k > 0 else []
