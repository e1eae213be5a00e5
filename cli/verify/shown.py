"""The evidence as tables on the terminal."""

from __future__ import annotations

import click

from heatwright.cli.figures import COLUMNS, cells
from heatwright.cli.tables import heading, mark, show, table
from heatwright.cli.verify.evidence import Evidence
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
    _print_verdict(evidence)


def _print_verdict(evidence: Evidence) -> None:
    if evidence.passed:
        click.secho(f"PASSED: all {len(evidence.checks)} checks hold.", fg="green", bold=True)
        return
    for mismatch in evidence.mismatches:
        click.secho(mismatch, fg="red")
    for check in evidence.failures:
        click.secho(f"{check.what}: {check.found} (limit: {check.limit})", fg="red")
    count = f"{len(evidence.failures)} of {len(evidence.checks)}"
    click.secho(f"FAILED: {count} checks do not hold.", fg="red", bold=True)
