"""The README and the other files around the sources: PlatformIO's project, the Arduino sketch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from heatwright.generator.plan.core import FAULT_COOLING_ABOVE_C, lockout_ends
from heatwright.generator.plan.documents.commissioning import Stage, commissioning
from heatwright.generator.plan.documents.lines import LineRow, lines
from heatwright.generator.plan.numbers import quantity, told_period
from heatwright.generator.plan.parts import File, Part, Wiring
from heatwright.generator.plan.programs.programs import ProgramsInWords, in_words
from heatwright.generator.plan.protection.hazards import HazardRow, hazards
from heatwright.generator.plan.protection.limits import limit
from heatwright.generator.plan.text import c_comment, markdown
from heatwright.generator.wiring import Wires
from heatwright.spec import (
    Controller,
    Gcode,
    LoopFacts,
    ModbusRtu,
    Nextion,
    Rule,
    SerialPlotter,
    Spec,
    facts_of,
    placed,
)
from heatwright.spec.boards import Board
from heatwright.spec.sensing.budget import Budget, budgets


@dataclass(frozen=True, slots=True)
class ReadmeNames:
    """The values for the templates of the README and the other files around the sources."""

    name: str
    title: str
    comment: str
    """The title in a comment of C."""
    platformio: str
    """The board's name in PlatformIO."""
    clock_hz: int | None
    """The clock, if it is not the board's own."""
    wires: Wires
    digest: str
    board: str
    clock_mhz: str
    sealed: bool
    proves: bool
    fuses: Fuses | None
    wiring: list[Wiring]
    commissioning: list[Stage]
    lines: list[LineRow]
    loops: list[ReadmeLoop]
    cooled_to: str
    """Temperature down to which a cooler runs while a fault is latched."""
    budgets: list[tuple[str, Budget]]
    rules: list[tuple[Rule, str]]
    """The rules, each with the condition that trips it."""
    hazards: list[HazardRow]
    relay: str | None
    cooled: bool
    countdown: str | None
    numbers: list[str]
    keypad: bool
    menu: bool
    host: Gcode | None
    modbus: ModbusRtu | None
    programs: ProgramsInWords | None
    touch: Nextion | None
    plotters: list[int]
    lockout: ReadmeLockout | None
    watchdog: str


def readme_names(spec: Spec, parts: Iterable[Part]) -> ReadmeNames:
    """Compute the values: wiring, settings, fault codes."""
    controller, facts = spec.controller, facts_of(spec.controller)
    identity = controller.identity
    wiring = list(dict.fromkeys(row for part in parts for row in part.wiring))  # each row once
    return ReadmeNames(
        name=identity.name,
        title=markdown(identity.title or identity.name),
        comment=c_comment(identity.title or identity.name),
        platformio=controller.board.platformio,
        clock_hz=controller.board.clock_hz if identity.clock_hz is not None else None,
        wires=Wires(identity.name, identity.board, wiring),
        digest=spec.digest,
        board=identity.board,
        clock_mhz=f"{controller.board.clock_hz / 1e6:g}",
        sealed=facts.checked,
        proves=facts.proves_watchdog,
        fuses=fuses(controller.board),
        wiring=wiring,
        commissioning=commissioning(controller, wiring),
        lines=lines(controller),
        loops=_loops(spec),
        cooled_to=f"{FAULT_COOLING_ABOVE_C:g} °C",
        budgets=list(budgets(controller)),
        rules=[(rule, limit(spec, rule.id)) for rule in facts.rules],
        hazards=hazards(controller),
        relay=controller.safety.relay,
        cooled=any(loop.cooler for loop in controller.loops.values()),
        countdown=_countdown(controller),
        numbers=_numbers(controller),
        keypad=facts.keypad is not None,
        menu=any(loop.keyed and loop.programmed for loop in facts.loops.values()),
        host=facts.gcode,
        modbus=facts.modbus,
        programs=in_words(controller),
        touch=facts.nextion,
        plotters=[each.baud for each in placed(controller, SerialPlotter).values()],
        lockout=_lockout(controller),
        watchdog=quantity(controller.safety.watchdog_s, "s"),
    )


@dataclass(frozen=True, slots=True)
class ReadmeLockout:
    """The values for the README about the lock-out."""

    after: str
    ends: str


def _lockout(controller: Controller) -> ReadmeLockout | None:
    lockout = controller.lockout
    if lockout is None:
        return None
    within = quantity(lockout.within_s, "s")
    after = (
        f"after {lockout.trips} faults of the machine, each less than {within} after the one before"
    )
    if lockout.trips == 1:
        after = "after each fault of the machine"
    return ReadmeLockout(after, lockout_ends(controller))


def _numbers(controller: Controller) -> list[str]:
    """Name the numbers that the keypad can set, with their ranges."""
    keypad = facts_of(controller).keypad
    return [
        f"{each.kind.key} from {each.minimum:g} to {quantity(each.maximum, each.kind.unit)}"
        for each in (facts_of(controller, keypad.loop).keyed_numbers if keypad else ())
    ]


def _countdown(controller: Controller) -> str | None:
    """Say when the countdown runs; None if there is none."""
    keypad = facts_of(controller).keypad
    if keypad is None or keypad.countdown is None:
        return None
    if keypad.countdown.counts == "at once":
        return "while the loop is on"
    return "from the moment when the setpoint is reached"


@dataclass(frozen=True, slots=True)
class ReadmeLoop:
    """A loop in the README."""

    facts: LoopFacts
    algorithm: str
    period: str
    initial: str
    minimum: str
    maximum: str


def _loops(spec: Spec) -> list[ReadmeLoop]:
    return [
        ReadmeLoop(
            facts=facts_of(spec.controller, name),
            algorithm=loop.algorithm.kind,
            period=told_period(loop),
            initial=f"{loop.setpoint.initial_c:g} °C",
            minimum=f"{loop.setpoint.minimum_c:g} °C",
            maximum=f"{loop.setpoint.maximum_c:g} °C",
        )
        for name, loop in spec.controller.loops.items()
    ]


class Fuses(NamedTuple):
    """The fuses of a bare chip for the right clock, and for detecting a low supply."""

    clock: str
    brown_out: str
    brown_out_v: str
    """Brown-out level for a supply of 5 V (data sheets, "Fuse Bits", "BODLEVEL Fuse Coding")."""
    has_wdton: bool
    """True if a fuse can switch the watchdog on permanently."""


def fuses(board: Board) -> Fuses | None:
    """Name the fuses of a bare chip; those of boards are set already."""
    if board.name != board.mcu:
        return None
    if board.is_old:
        return Fuses("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0", has_wdton=False)
    return Fuses("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3", has_wdton=True)


def project_files(spec: Spec, parts: Iterable[Part]) -> tuple[File, ...]:
    """Plan the files that make a folder of sources a project."""
    told = readme_names(spec, parts)
    return (
        File("platformio.ini", "project/platformio.ini.j2", told),
        File(f"{told.name}.ino", "project/sketch.ino.j2", told),
        File("wiring.svg", "project/wiring.svg.j2", told),
        File("README.md", "project/README.md.j2", told),
    )
