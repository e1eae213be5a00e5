"""The faults: tried in two processes, and as rows of a table."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from heatwright.cli.figures import NONE
from heatwright.cli.pool import spread
from heatwright.cli.talk import Job
from heatwright.sim.elf import Elf
from heatwright.sim.faults import Fault, FaultResult, catalogue, try_fault
from heatwright.spec import Controller

COLUMNS = ("fault", "trips", "after [s]", "limit [s]", "heater off after [s]", "peak [°C]")
TEXT_COLUMNS = 2


class _Piece(NamedTuple):
    controller: Controller
    elf: Path
    number: int


class _Count:
    """Tells one job how many pieces of work are done."""

    def __init__(self, job: Job, total: int) -> None:
        self._job = job
        self._total = total
        self._done = 0

    def __call__(self, done: float, total: float) -> None:
        pass

    def note(self, text: str) -> None:
        pass

    def end(self, text: str = "") -> None:
        del text
        self._done += 1
        self._job(self._done, self._total)


def try_faults(controller: Controller, elf: Path, job: Job) -> tuple[FaultResult, ...]:
    """Try every fault there is for a controller on its binary."""
    total = len(catalogue(controller, Elf(elf)))
    count = _Count(job, total)
    pieces = [_Piece(controller, elf, number) for number in range(total)]
    return tuple(spread(_try, pieces, [count] * total))


def _try(piece: _Piece, _: Job) -> FaultResult:
    return try_fault(_faults(piece.controller, piece.elf)[piece.number])


@lru_cache(maxsize=1)
def _faults(controller: Controller, elf: Path) -> tuple[Fault, ...]:
    """The faults are made once in each process: they hold the binary."""
    return catalogue(controller, Elf(elf))


def cells(result: FaultResult) -> tuple[str, ...]:
    """Return a fault's row in the order of COLUMNS, without the verdict."""
    nothing = "nothing" if result.expected else "nothing, as it must"
    return (
        result.fault.replace("_", " "),
        (result.rule or nothing).replace("_", " "),
        _seconds(result.tripped_after_s),
        _seconds(result.allowed_s),
        _seconds(result.heater_off_after_s),
        f"{result.peak_c:.1f}",
    )


def _seconds(value: float | None) -> str:
    return NONE if value is None else f"{value:.2f}"
