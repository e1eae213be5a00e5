"""Runs the rows of a comparison, on the binary or with the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware
from heatwright.cli.pool import spread
from heatwright.cli.running import run_binary, run_model
from heatwright.cli.talk import Job, Talk
from heatwright.sim.comparison import row_controller, row_scenario
from heatwright.sim.metrics import Metrics
from heatwright.sim.replay import ReplayResult, replay
from heatwright.sim.trace import StepLog
from heatwright.spec import ComparisonRow, Controller, Spec

if TYPE_CHECKING:
    from heatwright.generator.toolchain import BuildResult

OWN = "this spec"
"""Name of the row for the spec as it is."""


@dataclass(frozen=True)
class Outcome:
    """One row's run."""

    row: ComparisonRow
    figures: Metrics
    log: StepLog
    built: BuildResult | None
    """None with the model."""
    replayed: ReplayResult | None


@dataclass(frozen=True)
class _Piece:
    spec: Spec
    row: ComparisonRow
    model: bool


def rows_of(spec: Spec, wanted: Sequence[str]) -> tuple[ComparisonRow, ...]:
    """Return the rows of a spec, and the spec as it is; `wanted`: only of these names or kinds.

    Raises Refused where there is nothing to compare.
    """
    controller = spec.controller
    if controller.simulation is None or not controller.comparison:
        raise Refused(
            f"{spec.file_name}: has no `comparison` with rows to compare. "
            "Add some, such as {name: relay, setpoint: 50 °C, algorithm: {kind: on_off}}."
        )
    rows = controller.comparison
    own = _own_row(controller)
    if not any(_same(controller, own, row) for row in rows):
        rows = (*rows, own)
    known = {word for row in rows for word in _words(row)}
    for word in wanted:
        if word not in known:
            raise Refused(f"{spec.file_name}: no row is called {word}; there are {_list(rows)}.")
    chosen = set(wanted) or known
    return tuple(row for row in rows if chosen.intersection(_words(row)))


def _words(row: ComparisonRow) -> tuple[str, str]:
    return row.name, row.algorithm.kind


def _list(rows: Sequence[ComparisonRow]) -> str:
    return ", ".join(dict.fromkeys(word for row in rows for word in _words(row)))


def _own_row(controller: Controller) -> ComparisonRow:
    loop = next(iter(controller.loops.values()))
    return ComparisonRow.model_construct(
        name=OWN,
        setpoint_c=loop.setpoint.initial_c,
        algorithm=loop.algorithm,
        output=None,
        published=None,
    )


def _same(controller: Controller, own: ComparisonRow, row: ComparisonRow) -> bool:
    heater = controller.outputs[next(iter(controller.loops.values())).heater]
    return (
        row.setpoint_c == own.setpoint_c
        and row.algorithm == own.algorithm
        and (row.output is None or row.output == heater)
    )


def run_rows(
    spec: Spec, rows: Sequence[ComparisonRow], shown: Talk, *, model: bool
) -> list[Outcome]:
    """Run the rows, two at a time."""
    jobs = [shown.begin(f"{row.name}, {row.setpoint_c:g} °C", waits=True) for row in rows]
    return spread(run_row, [_Piece(spec, row, model) for row in rows], jobs)


def run_row(piece: _Piece, job: Job) -> Outcome:
    """Run one row in a process of its own."""
    varied = piece.spec._replace(controller=row_controller(piece.spec.controller, piece.row))
    controller = with_row_scenario(varied.controller)
    loop = next(iter(controller.loops))
    if piece.model:
        run = run_model(controller, job)
        return Outcome(piece.row, run.figures[loop], run.trace.steps[loop], None, None)
    built = build_firmware(varied, job)
    run = run_binary(controller, built.elf, job)
    log = run.trace.steps[loop]
    return Outcome(piece.row, run.figures[loop], log, built, replay(controller, log))


def with_row_scenario(controller: Controller) -> Controller:
    """Take the operator away: a row's setpoint is there from the start."""
    assert controller.simulation is not None  # noqa: S101 - looked at in rows_of
    simulation = controller.simulation.model_copy(update={"scenario": row_scenario(controller)})
    return controller.model_copy(update={"simulation": simulation})
