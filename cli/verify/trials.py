"""Trials of the binary: its closed loop, its timing, and every fault."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

from heatwright.cli.ends import Refused
from heatwright.cli.pool import spread
from heatwright.cli.running import Run, run_binary
from heatwright.cli.talk import Counter, Job, Talk
from heatwright.generator.toolchain import BuildResult
from heatwright.sim.avr import Core, instructions_by
from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import Fault, FaultResult, catalogue, try_fault
from heatwright.sim.faults.controller.upsets import Outcome, draw, try_upset
from heatwright.sim.plants import plant_module
from heatwright.sim.replay import ReplayResult, replay_all
from heatwright.sim.scenario import long_enough
from heatwright.sim.timing import Timing, measure
from heatwright.spec import Controller
from heatwright.spec.loading.suggest import advice


@dataclass(frozen=True)
class ClosedLoop:
    """The run of the binary, and the replay of each loop."""

    run: Run
    replays: dict[str, ReplayResult]


def closed_loop(controller: Controller, elf: Path | Elf, job: Job) -> ClosedLoop:
    """Run the scenario and replay its steps."""
    run = run_binary(long_enough(controller), elf, job)
    return ClosedLoop(run, replay_all(controller, run.trace.steps))


@dataclass(frozen=True)
class Trials:
    """The results of the trials."""

    loops: ClosedLoop
    timing: Timing
    faults: tuple[FaultResult, ...]
    known: int
    """Number of faults to try."""


@dataclass(frozen=True)
class _Piece:
    controller: Controller
    elf: Path
    stack_bytes: int
    what: int | Literal["closed loop", "timing"]
    """A fault's number in the catalogue, or one of the other trials."""
    core: Core
    """The simulator core; each worker process has to select it."""


def try_all(
    controller: Controller, built: BuildResult, core: Core, shown: Talk, only: Sequence[str] = ()
) -> Trials:
    """Run the closed loop, measure the timing and try every fault, on all cores.

    only -- ids of the faults to try; empty: all. Raises all that `closed_loop` raises; Refused: the
    machine lacks a fault of `only`.
    """
    _prepare(controller, built.elf)
    known = [each.id for each in _faults(controller, built.elf)]
    for name in only:
        if name not in known:
            raise Refused(f"This machine has no fault {name!r}. {advice(name, known)}")
    numbers = [number for number, name in enumerate(known) if not only or name in only]
    begun = [shown.begin(what) for what in ("Simulating the closed loop", "Measuring the timing")]
    counter = Counter(shown.begin("Injecting faults"), len(numbers))
    jobs: list[Job] = [*begun, *[counter] * len(numbers)]
    tried: list[int | Literal["closed loop", "timing"]] = ["closed loop", "timing", *numbers]
    pieces = [_Piece(controller, built.elf, built.stack_bytes, each, core) for each in tried]
    loops, timing, *faults = spread(_try, pieces, jobs)
    assert isinstance(loops, ClosedLoop)  # noqa: S101 - the first piece of work
    assert isinstance(timing, Timing)  # noqa: S101 - the second
    results = tuple(each for each in faults if isinstance(each, FaultResult))
    return Trials(loops, timing, results, len(known))


def _prepare(controller: Controller, elf: Path) -> None:
    """Import and read all that workers need, once: they are forked from this process."""
    AvrDevice(controller, program_of(elf))
    if controller.simulation is not None:
        plant_module(controller.simulation.plant.kind)


def try_upsets(  # noqa: PLR0913, PLR0917 - a trial's inputs
    controller: Controller, built: BuildResult, core: Core, numbers: range, seed: int, shown: Talk
) -> tuple[Outcome, ...]:
    """Try the random upsets of these numbers, on all cores."""
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


def _try(piece: _Piece, job: Job) -> ClosedLoop | Timing | FaultResult:
    controller, program = piece.controller, program_of(piece.elf)
    with instructions_by(piece.core):
        if piece.what == "closed loop":
            return closed_loop(controller, program, job)
        if piece.what == "timing":
            return measure(controller, program, static_stack_bytes=piece.stack_bytes, progress=job)
        return try_fault(_faults(controller, piece.elf)[piece.what])


@lru_cache(maxsize=1)
def _faults(controller: Controller, elf: Path) -> tuple[Fault, ...]:
    """Make the faults once: they hold the binary, and forked workers share them."""
    return catalogue(controller, program_of(elf))
