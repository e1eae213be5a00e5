"""`heatwright compare`: compares algorithms with each other, and with published figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Status
from heatwright.cli.options import (
    PLOTS,
    File,
    json_option,
    print_json,
    spec_argument,
    with_examples,
)
from heatwright.cli.talk import talk
from heatwright.cli.targets import check_target

if TYPE_CHECKING:
    from collections.abc import Sequence

    from heatwright.cli.compare.rows import Outcome
    from heatwright.spec import Spec


@with_examples(
    "heatwright compare oven.yaml --plot oven.html",
    "heatwright compare oven.yaml --algorithm pid --model",
)
@spec_argument
@click.option(
    "--algorithm",
    "wanted",
    metavar="NAME",
    multiple=True,
    help="Only rows of this name or kind, such as pid; can be given several times.",
)
@click.option(
    "--loop",
    "loops",
    metavar="NAME",
    multiple=True,
    help="Only rows of this loop; can be given several times.",
)
@click.option("--model", is_flag=True, help="Simulate the reference model, not the binaries.")
@click.option("--plot", type=File, metavar="OUT", help="Draw the rows: .png, .svg or .html.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    wanted: tuple[str, ...],
    loops: tuple[str, ...],
    model: bool,
    plot: Path | None,
    as_json: bool,
) -> int:
    """Compare algorithms on the simulated machine.

    Each row of `comparison` in the spec is generated, built and simulated, and each control step
    of its binary compared with the reference model. Published figures stand below ours. The spec's
    own algorithm comes last, unless a row is the same. Each row varies one loop; all others stay as
    they are after power-up.
    """
    check_target(plot, PLOTS)
    from heatwright.cli.compare.rows import rows_of, run_rows  # noqa: PLC0415
    from heatwright.cli.compare.tabled import mismatches, rows_json  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    rows = rows_of(loaded, wanted, loops)
    with talk() as shown:
        outcomes = run_rows(loaded, rows, shown, model=model)
    device = "model" if model else "binary"
    if plot is not None:
        _draw(loaded, outcomes, device, plot)
    if as_json:
        print_json(spec=str(spec), digest=loaded.digest, device=device, rows=rows_json(outcomes))
    else:
        _print(loaded, outcomes, device, plot)
    return Status.FAILED if mismatches(outcomes) else Status.DONE


def _print(spec: Spec, outcomes: Sequence[Outcome], device: str, plot: Path | None) -> None:
    from heatwright.cli.compare.tabled import COLUMNS, lines, mismatches, ticks  # noqa: PLC0415
    from heatwright.cli.tables import heading, show, table  # noqa: PLC0415

    plural = "binaries" if device == "binary" else "model"
    heading(f"{spec.controller.identity.name}, simulated with the {plural}")
    rows = [line for outcome in outcomes for line in lines(outcome)]
    show(table(COLUMNS, rows))
    if device == "binary":
        click.echo(f"{ticks(outcomes)} control steps replayed, {mismatches(outcomes)} mismatches")
    for outcome in outcomes:
        for loop, replayed in outcome.replays.items():
            for mismatch in replayed.first:
                click.secho(f"{outcome.title}, loop {loop}: {mismatch}", fg="red")
    if plot is not None:
        click.echo(str(plot))


def _draw(spec: Spec, outcomes: Sequence[Outcome], device: str, plot: Path) -> None:
    from heatwright.cli.targets import whole  # noqa: PLC0415

    with whole(plot) as fresh:
        if plot.suffix.lower() == ".html":
            from heatwright.cli.report.compare_page import compare_page  # noqa: PLC0415

            fresh.write_text(compare_page(spec, outcomes, device), encoding="utf-8")
        else:
            from heatwright.cli.compare.figure import comparison_figure  # noqa: PLC0415
            from heatwright.sim.plots.plot import save  # noqa: PLC0415

            save(comparison_figure(spec, outcomes), fresh)
