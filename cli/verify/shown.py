"""The evidence as tables on the terminal."""

import click
from rich.text import Text

from heatwright.cli.results import speed_text
from heatwright.cli.tables import heading, mark, show, show_figures, table
from heatwright.cli.verify.evidence import Evidence
from heatwright.cli.verify.rows import (
    CHAIN_COLUMNS,
    CHECK_COLUMNS,
    CHECK_TEXTS,
    FAULT_COLUMNS,
    FAULT_TEXTS,
    FIGURE_COLUMNS,
    FIGURE_TEXTS,
    chain_cells,
    check_cells,
    fault_cells,
    figure_cells,
)
from heatwright.spec.quantity import duration


def print_evidence(evidence: Evidence) -> None:
    """Print everything, the verdict last."""
    identity = evidence.spec.controller.identity
    run = evidence.trials.loops.run
    heading(f"{identity.name}: {identity.title or ''}".rstrip(": "))
    click.echo(f"{speed_text(run, ' of the closed loop')}\n")
    for line in evidence.unusual:
        click.echo(f"{line}\n")
    heading("Closed loop")
    show_figures(run.figures)
    heading("Checks")
    _print_judged(CHECK_COLUMNS, CHECK_TEXTS, [(check_cells(c), c.passed) for c in evidence.checks])
    if evidence.chains:
        heading("Analog sensors, from the tip to the reading, compared with their exact curves")
        show(table(CHAIN_COLUMNS, chain_cells(evidence.chains)))
    timing = evidence.trials.timing
    heading(f"Timing, over {duration(round(timing.seconds))} cycle by cycle")
    figures = [(figure_cells(each), each.passed) for each in timing.figures.values()]
    _print_judged(FIGURE_COLUMNS, FIGURE_TEXTS, figures)
    click.echo(f"the processor sleeps {timing.idle_fraction:.2%} of the time\n")
    heading("Faults")
    faults = [(fault_cells(each), each.passed) for each in evidence.trials.faults]
    _print_judged(FAULT_COLUMNS, FAULT_TEXTS, faults)
    _print_verdict(evidence)


def _print_judged(
    columns: tuple[str, ...], texts: int, rows: list[tuple[tuple[str, ...], bool]]
) -> None:
    judged: list[tuple[str | Text, ...]] = [(*cells_, mark(passed)) for cells_, passed in rows]
    show(table((*columns, ""), judged, text_columns=texts))


def _print_verdict(evidence: Evidence) -> None:
    if evidence.passed:
        rest = f" Not tried: {evidence.left_out} faults." if evidence.left_out else ""
        click.secho(f"PASSED: all {evidence.count} checks hold.{rest}", fg="green", bold=True)
        return
    for mismatch in evidence.mismatches:
        click.secho(mismatch, fg="red")
    for failure in evidence.failures:
        click.secho(failure, fg="red")
    count = f"{len(evidence.failures)} of {evidence.count}"
    click.secho(f"FAILED: {count} checks do not hold.", fg="red", bold=True)
    failed = [f"--fault {each.fault}" for each in evidence.trials.faults if not each.passed]
    if failed and not evidence.left_out:
        click.echo(f"To repeat only these faults: {' '.join(failed)}")
