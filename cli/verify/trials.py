"""What is tried on the binary beside its closed loop: its timing, and every fault."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from heatwright.cli.pool import spread
from heatwright.cli.talk import Counter, Job, Talk
from heatwright.generator.toolchain import BuildResult
from heatwright.sim.avr import Core, instructions_by
from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults import Fault, FaultResult, catalogue, try_fault
from heatwright.sim.faults.controller.upsets import Outcome, draw, try_upset
from heatwright.sim.timing import Timing, measure
from heatwright.spec import Controller


@dataclass(frozen=True)
class Trials:
    """What was found."""

    timing: Timing
    faults: tuple[FaultResult, ...]


@dataclass(frozen=True)
class _Piece:
    controller: Controller
    elf: Path
    stack_bytes: int
    fault: int | None
    """Its number in the catalogue; None: the timing."""
    core: Core
    """The choice of the core: each worker is a process of its own, so it has to be passed on."""


def try_all(controller: Controller, built: BuildResult, core: Core, shown: Talk) -> Trials:
    """Measure the timing and try every fault there is for a controller, on all cores."""
    count = len(_faults(controller, built.elf))
    counter = Counter(shown.begin("Injecting faults"), count)
    jobs: list[Job] = [shown.begin("Measuring the timing"), *[counter] * count]
    timing, *faults = spread(
        _try,
        [
            _Piece(controller, built.elf, built.stack_bytes, each, core)
            for each in (None, *range(count))
        ],
        jobs,
    )
    assert isinstance(timing, Timing)  # noqa: S101 - the first piece of work
    return Trials(timing, tuple(each for each in faults if isinstance(each, FaultResult)))


def try_upsets(  # noqa: PLR0913, PLR0917 - what is tried, and on what
    controller: Controller, built: BuildResult, core: Core, numbers: range, seed: int, shown: Talk
) -> tuple[Outcome, ...]:
    """Try drawn upsets of these numbers, on all cores."""
    counter = Counter(shown.begin("Flipping bits"), len(numbers))
    pieces = [(controller, built.elf, core, number, seed) for number in numbers]
    return tuple(spread(_upset, pieces, [counter] * len(pieces)))


def _upset(piece: tuple[Controller, Path, Core, int, int], _: Job) -> Outcome:
    controller, elf, core, number, seed = piece
    program = program_of(elf)
    with instructions_by(core):
        return try_upset(controller, program, draw(controller, program, number, seed))


@lru_cache(maxsize=1)
def program_of(elf: Path) -> Elf:
    """Read a binary, once."""
    return Elf(elf)


def _try(piece: _Piece, job: Job) -> Timing | FaultResult:
    with instructions_by(piece.core):
        if piece.fault is None:
            program = program_of(piece.elf)
            return measure(
                piece.controller, program, static_stack_bytes=piece.stack_bytes, progress=job
            )
        return try_fault(_faults(piece.controller, piece.elf)[piece.fault])


@lru_cache(maxsize=1)
def _faults(controller: Controller, elf: Path) -> tuple[Fault, ...]:
    """Make the faults, once: they hold the binary, and workers have them from who forked them."""
    return catalogue(controller, program_of(elf))
