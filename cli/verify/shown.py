"""The evidence as tables on the terminal."""

from __future__ import annotations

import click
from rich.text import Text

from heatwright.cli.figures import COLUMNS, cells
from heatwright.cli.tables import heading, mark, show, table
from heatwright.cli.verify.evidence import Evidence
from heatwright.cli.verify.faults import COLUMNS as FAULT_COLUMNS
from heatwright.cli.verify.faults import TEXT_COLUMNS as FAULT_TEXT_COLUMNS
from heatwright.cli.verify.faults import cells as fault_cells
from heatwright.spec.quantity import duration


def print_evidence(evidence: Evidence) -> None:
    """Print everything, the verdict last."""
    identity = evidence.spec.controller.identity
    run = evidence.loops.run
    heading(f"{identity.name}: {identity.title or ''}".rstrip(": "))
    click.echo(
        f"{duration(round(run.trace.duration_s))} of the closed loop simulated in "
        f"{run.wall_s:.2f} s, {run.speed:.0f} times faster than the machine\n"
    )
    heading("Closed loop")
    show(table(("loop", *COLUMNS), [(loop, *cells(each)) for loop, each in run.figures.items()]))
    heading("What has to hold")
    rows = [(each.what, each.limit, each.found, mark(each.passed)) for each in evidence.checks]
    show(table(("", "limit", "found", ""), rows, text_columns=3))
    heading("Faults")
    tried: list[tuple[str | Text, ...]] = [
        (*fault_cells(each), mark(each.passed)) for each in evidence.faults
    ]
    show(table((*FAULT_COLUMNS, ""), tried, text_columns=FAULT_TEXT_COLUMNS))
    _print_verdict(evidence)


def _print_verdict(evidence: Evidence) -> None:
    if evidence.passed:
        click.secho(f"PASSED: all {evidence.count} checks hold.", fg="green", bold=True)
        return
    for mismatch in evidence.mismatches:
        click.secho(mismatch, fg="red")
    for failure in evidence.failures:
        click.secho(failure, fg="red")
    count = f"{len(evidence.failures)} of {evidence.count}"
    click.secho(f"FAILED: {count} checks do not hold.", fg="red", bold=True)
