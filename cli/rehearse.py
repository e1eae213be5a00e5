"""Runs the reference model on a spec's healthy machine: no protection may trip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from heatwright.cli.pool import spread
from heatwright.cli.talk import Job, talk
from heatwright.spec import Problem, Spec
from heatwright.spec.loading.loader import problem_of

if TYPE_CHECKING:
    from heatwright.sim.rehearsal import Part, Tripped
    from heatwright.spec import Controller


@dataclass(frozen=True)
class _Piece:
    controller: Controller
    part: Part


def rehearsed(spec: Spec) -> tuple[Problem, ...]:
    """Return a problem for each rule that trips, in file order; none without a machine."""
    from heatwright.sim.rehearsal import findings, parts  # noqa: PLC0415 - it imports numpy

    pieces = [_Piece(spec.controller, part) for part in parts(spec.controller)]
    if not pieces:
        return ()
    with talk() as shown:
        jobs = [shown.begin(f"Running {each.part}", waits=True) for each in pieces]
        tripped = [each for found in spread(_rehearse, pieces, jobs) for each in found]
        if tripped:
            shown.begin("Looking for numbers that do not trip")
        problems = [problem_of(spec.tree, each) for each in findings(spec.controller, tripped)]
    return tuple(sorted(problems, key=lambda problem: (problem.line, problem.column)))


def _rehearse(piece: _Piece, job: Job) -> tuple[Tripped, ...]:
    from heatwright.sim.rehearsal import rehearse  # noqa: PLC0415

    return rehearse(piece.controller, piece.part, job)
