"""`heatwright tune`: gains for a loop, by several methods side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.command import Command
from heatwright.cli.ends import Refused, Status
from heatwright.cli.options import Amount, File, json_option, print_json, spec_argument
from heatwright.cli.targets import check_target, whole

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from heatwright.cli.tune.methods import Failed, Judged, Task, Tried
    from heatwright.spec import Spec

METHODS = ("relay", "simc", "lambda")
PICTURES = (".png", ".svg")


@click.command(
    cls=Command,
    examples=(
        "heatwright tune extruder.yaml",
        "heatwright tune oven.yaml --method simc --at 60C --plot oven.png",
        "heatwright tune oven.yaml --method lambda --lambda 30s",
    ),
)
@spec_argument
@click.option(
    "--method",
    "asked",
    type=click.Choice(METHODS),
    multiple=True,
    help="Only this method; can be given several times. By default all that the spec allows.",
)
@click.option("--loop", help="The loop to tune; by default the first.")
@click.option("--at", "at_c", type=Amount("TEMPERATURE"), help="Tune at this temperature.")
@click.option(
    "--lambda", "lambda_s", type=Amount("DURATION"), help="Closed loop's time constant for lambda."
)
@click.option(
    "--tauc", "tauc_s", type=Amount("DURATION"), help="Closed loop's time constant for simc."
)
@click.option("--plot", type=File, metavar="OUT", help="Draw Bode diagram and trial: .png or .svg.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    asked: tuple[str, ...],
    loop: str | None,
    at_c: float | None,
    lambda_s: float | None,
    tauc_s: float | None,
    plot: Path | None,
    as_json: bool,
) -> int:
    """Find the gains of a PID.

    relay is the experiment that the firmware does by command, here on the simulated machine; simc
    and lambda are rules for the machine's model. Each is judged by the margins of the sampled loop
    and tried from cold on the bench, beside the spec's own gains. The gains of the first method are
    printed as YAML to paste. The exit status is 1 if it found none.
    """
    check_target(plot, PICTURES)
    for name, value in (("--lambda", lambda_s), ("--tauc", tauc_s)):
        if value is not None and value <= 0:
            raise Refused(f"{name}: must be above 0.")
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.cli.tune.methods import Judged, find, try_all  # noqa: PLC0415
    from heatwright.cli.tune.task import methods_of, task_of  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    task = task_of(loaded, loop, at_c=at_c, lambda_s=lambda_s, tauc_s=tauc_s)
    methods = methods_of(task, asked, METHODS)
    with talk() as shown:
        rows = find(task, methods, shown)
        good = [row for row in rows if isinstance(row, Judged)]
        tried = try_all(task, good, shown)
    first = methods[0] if not asked else next(each for each in asked if each in methods)
    chosen = next((row for row in good if row.method == first), None)
    if plot is not None:
        _draw(task, good, tried, plot)
    if as_json:
        _print_json(spec, loaded, task, rows, tried, chosen)
    else:
        _print(task, rows, tried, chosen, plot)
    return Status.DONE if chosen is not None else Status.FAILED


def _print(
    task: Task,
    rows: Sequence[Judged | Failed],
    tried: Mapping[str, Tried],
    chosen: Judged | None,
    plot: Path | None,
) -> None:
    from heatwright.cli.results import fault_text  # noqa: PLC0415
    from heatwright.cli.tables import heading, show, table  # noqa: PLC0415
    from heatwright.cli.tune.methods import Failed  # noqa: PLC0415
    from heatwright.cli.tune.tabled import COLUMNS, block, legend, line  # noqa: PLC0415

    heading(f"{task.controller.identity.name}, loop {task.loop}")
    show(table(COLUMNS, [line(row, tried.get(row.method)) for row in rows]))
    for text in legend(task):
        click.echo(f"  {text}")
    for row in rows:
        if isinstance(row, Failed):
            click.secho(f"  {row.method}: no gains: {row.reason}", fg="red")
        elif row.method in tried:
            for fault in tried[row.method].faults:
                click.secho(f"  {row.method}: {fault_text(fault)}", fg="red")
    if chosen is not None:
        click.echo(f"\n{block(chosen)}", nl=False)
    if plot is not None:
        click.echo(str(plot))


def _print_json(  # noqa: PLR0913, PLR0917 - what there is to tell
    spec: Path,
    loaded: Spec,
    task: Task,
    rows: Sequence[Judged | Failed],
    tried: Mapping[str, Tried],
    chosen: Judged | None,
) -> None:
    from heatwright.cli.tune.tabled import block, model_json, rows_json  # noqa: PLC0415

    print_json(
        {
            "spec": str(spec),
            "digest": loaded.digest,
            "loop": task.loop,
            "at": task.target_c,
            "model": model_json(task),
            "methods": rows_json(rows, tried),
            "chosen": None if chosen is None else chosen.method,
            "yaml": None if chosen is None else block(chosen),
        }
    )


def _draw(task: Task, rows: Sequence[Judged], tried: Mapping[str, Tried], plot: Path) -> None:
    from heatwright.cli.tune.figure import tuned_figure  # noqa: PLC0415
    from heatwright.sim.plot import save  # noqa: PLC0415

    with whole(plot) as fresh:
        save(tuned_figure(task, rows, tried), fresh)
