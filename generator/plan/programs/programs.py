"""Programs and their progress in EEPROM."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, pair
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import c_string, markdown
from heatwright.spec import Controller
from heatwright.spec.board.eeprom import CELL_WRITES, Area, layout
from heatwright.spec.programs import (
    FASTEST_K_PER_H,
    LONGEST_SEGMENT_S,
    AfterPowerLoss,
    Program,
    Programs,
    Segment,
)
from heatwright.spec.quantity import duration

KINDS = {kind: f"PROGRAM_{kind.upper()}" for kind in ("over", "rate", "fast", "hold", "until")}
UINT16_MAX = 0xFFFF
PER_KELVIN = 10
"""Steps of a kelvin in a program: temperatures and rates are stored in whole tenths."""
FLOAT_ERROR = 1e-6
"""Tolerance of a rounding: far below a hundredth, far above the errors of binary numbers."""


@dataclass(frozen=True, slots=True)
class CodedSegment:
    """A segment, as it is written in C."""

    kind: str
    to_dc: int
    amount: str
    meaning: str


@dataclass(frozen=True, slots=True)
class StoredProgram:
    """A program of the spec, which the firmware contains."""

    where: str
    name: str
    segments: list[CodedSegment]


@dataclass(frozen=True, slots=True)
class ProgramsNames:
    """The values for the templates of the programs."""

    where: str
    places: int
    places_where: str
    points: int
    points_where: str
    stored: list[StoredProgram]


def programs(root: Source) -> Part:
    """Plan where programs are stored, and where the running one saves its progress."""
    given = root.controller.programs
    if given is None:
        return Part()
    source = root.at("programs")
    context = ProgramsNames(
        where=source.where,
        places=given.places,
        places_where=source.at("places").where,
        points=given.points,
        points_where=source.at("points").where,
        stored=[
            _program(source.at("stored", index), each) for index, each in enumerate(given.stored)
        ],
    )
    return Part(
        files=(
            *pair("programs", "programs/programs", context),
            *pair("progress", "programs/progress"),
        ),
        groups=(Group("Programs in EEPROM", _constants(source)),),
        start_calls=(Call(Stage.RESTORE, "progress.h", "progress_start();"),),
        tick_calls=(
            Call(Stage.STORE, "progress.h", "progress_tick();"),
            Call(Stage.STORE, "programs.h", "programs_tick();"),
        ),
    )


@dataclass(frozen=True, slots=True)
class ProgramsInWords:
    """The values for the README about programs."""

    loop: str
    places: int
    points: int
    names: str
    on_fault: str
    after_power_loss: str
    save_every: str
    years: int


def in_words(controller: Controller) -> ProgramsInWords | None:
    """The README's values about programs; None if there are none."""
    given = controller.programs
    if given is None:
        return None
    return ProgramsInWords(
        loop=given.loop,
        places=given.places,
        points=given.points,
        names=", ".join(markdown(program.name) for program in given.stored),
        on_fault=_on_fault(given),
        after_power_loss=_after_power_loss(given.after_power_loss),
        save_every=duration(given.save_every_s),
        years=math.floor(layout(controller).progress.years(given.save_every_s)),
    )


def _on_fault(programs: Programs) -> str:
    if programs.on_fault == "stop":
        return "A fault ends it."
    within = quantity(programs.after_power_loss.resume_within_k, "K")
    otherwise = {"stop": "ends", "pause": "is paused, and can be resumed at any temperature"}
    return (
        "A fault interrupts it. After acknowledging, it can be resumed: it continues if "
        f"the temperature has changed by no more than {within}, otherwise it "
        f"{otherwise[programs.after_power_loss.otherwise]}."
    )


def _after_power_loss(power: AfterPowerLoss) -> str:
    otherwise = {"stop": "ends", "pause": "is paused"}[power.otherwise]
    if power.resume_within_k == 0:
        return f"it {otherwise}"
    within = quantity(power.resume_within_k, "K")
    return f"it continues if the temperature has changed by {within} at most, or it {otherwise}"


def _program(source: Source, program: Program) -> StoredProgram:
    segments = [_segment(segment) for segment in program.segments]
    return StoredProgram(source.where, c_string(program.name), segments)


def _segment(segment: Segment) -> CodedSegment:
    """Return a segment's C, and its text in words of the spec."""
    amount, how = _amount(segment)
    what = "hold" if segment.to_c is None else f"to {quantity(segment.to_c, 'degC')}"
    return CodedSegment(
        kind=KINDS[segment.kind],
        to_dc=round((segment.to_c or 0.0) * PER_KELVIN),
        amount=f"{amount}u" if amount <= UINT16_MAX else f"{amount}ul",
        meaning=f"{what} {how}",
    )


def _amount(segment: Segment) -> tuple[int, str]:
    """Return a segment's time, s, or its rate, in tenths of a kelvin per hour, and its text."""
    if segment.over_s is not None:
        return round(segment.over_s), f"over {duration(segment.over_s)}"
    if segment.at_k_per_h is not None:
        rate = quantity(segment.at_k_per_h, "K/h")
        return round(segment.at_k_per_h * PER_KELVIN), f"at {rate}"
    if segment.hold_s is not None:
        return round(segment.hold_s), duration(segment.hold_s)
    return 0, "as fast as possible" if segment.fast else "until the operator continues"


def _constants(source: Source) -> tuple[Constant, ...]:
    controller = source.controller
    assert controller.programs is not None  # noqa: S101 - the caller has looked
    setpoint = controller.loops[controller.programs.loop].setpoint
    bounds = Source(source.spec, ("loops", controller.programs.loop, "setpoint"))
    lowest = math.ceil(setpoint.minimum_c * PER_KELVIN - FLOAT_ERROR)
    highest = math.floor(setpoint.maximum_c * PER_KELVIN + FLOAT_ERROR)
    return (
        *_places(source),
        Constant(
            "PROGRAM_LOWEST_DC", _integer(lowest),
            f"{bounds.at('minimum').where}: {quantity(setpoint.minimum_c, 'degC')} in tenths",
        ),
        Constant(
            "PROGRAM_HIGHEST_DC", _integer(highest),
            f"{bounds.at('maximum').where}: {quantity(setpoint.maximum_c, 'degC')} in tenths",
        ),
        Constant(
            "PROGRAM_MOST_SECONDS", f"{LONGEST_SEGMENT_S:.0f}ul",
            "31 days: no segment takes longer",
        ),
        Constant(
            "PROGRAM_MOST_TENTHS_PER_HOUR", f"{round(FASTEST_K_PER_H * PER_KELVIN)}u",
            "no rate of a segment is higher, in 0.1 K/h",
        ),
    )  # fmt: skip


def _places(source: Source) -> tuple[Constant, ...]:
    """Return the places of programs and progress in the EEPROM, and how long its cells last."""
    given = source.controller.programs
    assert given is not None  # noqa: S101 - the caller has looked
    areas = layout(source.controller)
    programs, progress = areas.programs, areas.progress
    every = duration(given.save_every_s)
    years = math.floor(progress.years(given.save_every_s))
    saves = f"{progress.slots * CELL_WRITES / 1e6:.1f} million saves"
    return (
        Constant("PROGRAMS_EEPROM", f"{programs.start}u", _extent(programs)),
        Constant(
            "PROGRAMS_SLOT_BYTES", f"{programs.slot_bytes}u",
            f"{source.at('points').where}: {given.points} segments; two slots per program",
        ),
        Constant("PROGRESS_EEPROM", f"{progress.start}u", _extent(progress)),
        Constant("PROGRESS_SLOT_BYTES", f"{progress.slot_bytes}u", "a record with its frame"),
        Constant(
            "PROGRESS_SLOTS", f"{progress.slots}u",
            f"{source.at('save_every').where}: {every}; {saves}, {years} years of running",
        ),
    )  # fmt: skip


def _extent(area: Area) -> str:
    return f"bytes {area.start} to {area.end - 1} of the EEPROM"


def _integer(value: int) -> str:
    return f"({value})" if value < 0 else str(value)
