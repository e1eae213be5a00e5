"""Runs the rows of a comparison, on the binary or with the model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware
from heatwright.cli.pool import spread
from heatwright.cli.running import run_binary, run_model
from heatwright.cli.talk import Job, Talk
from heatwright.sim.comparison import row_scenario
from heatwright.sim.judges.metrics import Metrics
from heatwright.sim.replay import ReplayResult, replay
from heatwright.sim.trace import StepLog
from heatwright.spec import ComparisonRow, Controller, Spec, facts_of, row_controller, row_loop

if TYPE_CHECKING:
    from heatwright.generator.toolchain import BuildResult

OWN = "this spec"
"""Name of the rows with the spec's own algorithms."""


@dataclass(frozen=True)
class Outcome:
    """One row's run."""

    row: ComparisonRow
    loop: str
    """The loop that the row varies; `figures` and `log` are those of this loop."""
    title: str
    figures: Metrics
    log: StepLog
    built: BuildResult | None
    """The binary and its sizes; None if the model was run."""
    replays: Mapping[str, ReplayResult]
    """Comparison of each loop's steps with the model, by loop; empty if the model was run."""


@dataclass(frozen=True)
class _Piece:
    spec: Spec
    row: ComparisonRow
    model: bool


def rows_of(
    spec: Spec, wanted: Sequence[str], loops: Sequence[str] = ()
) -> tuple[ComparisonRow, ...]:
    """Return the rows of a spec, loop by loop; each loop's last row is the spec's own algorithm.

    wanted -- only rows of these names or kinds; loops -- only rows of these loops. Raises Refused:
    there is nothing to compare.
    """
    controller = spec.controller
    if controller.simulation is None or not controller.comparison:
        raise Refused(
            f"{spec.file_name}: has no `comparison` with rows to compare. "
            "Add some, such as {name: relay, setpoint: 50 °C, algorithm: {kind: on_off}}."
        )
    if lost := next((loop for loop in loops if loop not in controller.loops), None):
        able = ", ".join(controller.loops)
        raise Refused(f"{spec.file_name}: has no loop {lost}; there are {able}.")
    chosen_loops = [loop for loop in controller.loops if loop in (loops or controller.loops)]
    rows = [row for loop in chosen_loops for row in _rows_of_loop(controller, loop)]
    if not rows:
        raise Refused(f"{spec.file_name}: no row varies the loop {loops[0]}.")
    known = {word for row in rows for word in _words(row)}
    for word in wanted:
        if word not in known:
            raise Refused(f"{spec.file_name}: no row is called {word}; there are {_list(rows)}.")
    chosen = set(wanted) or known
    return tuple(row for row in rows if chosen.intersection(_words(row)))


def _rows_of_loop(controller: Controller, loop: str) -> Iterator[ComparisonRow]:
    rows = [row for row in controller.comparison if row_loop(controller, row) == loop]
    yield from rows
    if rows:
        own = _own_row(controller, loop, rows[0])
        if not any(_same(controller, own, row) for row in rows):
            yield own


def _words(row: ComparisonRow) -> tuple[str, str]:
    return row.name, row.algorithm.kind


def _list(rows: Sequence[ComparisonRow]) -> str:
    return ", ".join(dict.fromkeys(word for row in rows for word in _words(row)))


def _own_row(controller: Controller, name: str, first: ComparisonRow) -> ComparisonRow:
    """Return a row for the loop as it is, at its initial setpoint; if that is 0, at `first`'s."""
    loop = controller.loops[name]
    off = loop.setpoint.initial_c == 0.0 and facts_of(controller, name).hosted
    return ComparisonRow.model_construct(
        name=OWN,
        loop=name,
        setpoint_c=first.setpoint_c if off else loop.setpoint.initial_c,
        algorithm=loop.algorithm,
        output=None,
        published=None,
    )


def _same(controller: Controller, own: ComparisonRow, row: ComparisonRow) -> bool:
    heater = controller.outputs[controller.loops[row_loop(controller, own)].heater]
    return (
        row.setpoint_c == own.setpoint_c
        and row.algorithm == own.algorithm
        and (row.output is None or row.output == heater)
    )


def run_rows(
    spec: Spec, rows: Sequence[ComparisonRow], shown: Talk, *, model: bool
) -> list[Outcome]:
    """Run the rows, on all cores."""
    jobs = [shown.begin(title_of(spec.controller, row), waits=True) for row in rows]
    return spread(run_row, [_Piece(spec, row, model) for row in rows], jobs)


def title_of(controller: Controller, row: ComparisonRow) -> str:
    """Write a row's name and setpoint, and its loop where there are several."""
    prefix = f"{row_loop(controller, row)}: " if len(controller.loops) > 1 else ""
    return f"{prefix}{row.name}, {row.setpoint_c:g} °C"


def run_row(piece: _Piece, job: Job) -> Outcome:
    """Run one row; `run_rows` calls this in worker processes."""
    varied = piece.spec._replace(controller=row_controller(piece.spec.controller, piece.row))
    controller = with_row_scenario(varied.controller)
    built = None if piece.model else build_firmware(varied, job)
    run = run_binary(controller, built.elf, job) if built else run_model(controller, job)
    loop, steps = row_loop(controller, piece.row), run.trace.steps
    return Outcome(
        piece.row,
        loop,
        title_of(controller, piece.row),
        run.figures[loop],
        steps[loop],
        built,
        {name: replay(controller, log, name) for name, log in steps.items() if built},
    )


def with_row_scenario(controller: Controller) -> Controller:
    """Remove the operator: a row's setpoint holds from the start."""
    simulation = controller.simulated.model_copy(update={"scenario": row_scenario(controller)})
    return controller.model_copy(update={"simulation": simulation})
