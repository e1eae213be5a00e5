"""`heatwright tune`: finds a loop's gains by several methods, and compares them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from heatwright.cli.ends import Refused, Status
from heatwright.cli.options import (
    Amount,
    File,
    json_option,
    print_json,
    spec_argument,
    with_examples,
)
from heatwright.cli.targets import check_target, whole

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from heatwright.cli.talk import Talk
    from heatwright.cli.tune.methods import Failed, Judged, Task, Tried
    from heatwright.cli.tune.robust import Trade, Wish
    from heatwright.cli.tune.task import Job, Plan
    from heatwright.spec import Spec

METHODS = ("relay", "simc", "lambda")
PICTURES = (".png", ".svg")
MOST_MACHINES = 256
MOST_SPREAD_PERCENT = 80.0


@with_examples(
    "heatwright tune extruder.yaml",
    "heatwright tune oven.yaml --method simc --at 60C --plot oven.png",
    "heatwright tune oven.yaml --method lambda --lambda 30s",
    "heatwright tune barrel.yaml --loop die",
    "heatwright tune oven.yaml --log step.csv",
    "heatwright tune oven.yaml --robust --machines 32 --spread 30%",
)
@spec_argument
@click.option(
    "--method",
    "asked",
    type=click.Choice(METHODS),
    multiple=True,
    help="Only this method; can be given several times. By default all that the spec allows.",
)
@click.option(
    "--loop",
    "loops",
    metavar="NAME",
    multiple=True,
    help="Only this loop; can be given several times. By default all, one after the other.",
)
@click.option(
    "--log", type=File, help="Tune for the machine of this recorded step, not for the spec's."
)
@click.option("--at", "at_c", type=Amount("TEMPERATURE"), help="Tune at this temperature.")
@click.option(
    "--lambda", "lambda_s", type=Amount("DURATION"), help="Closed loop's time constant for lambda."
)
@click.option(
    "--tauc", "tauc_s", type=Amount("DURATION"), help="Closed loop's time constant for simc."
)
@click.option(
    "--robust",
    "is_robust",
    is_flag=True,
    help="Improve the gains for random machines about the spec's, and show what that costs.",
)
@click.option(
    "--machines",
    type=click.IntRange(2, MOST_MACHINES),
    default=16,
    show_default=True,
    help="How many random machines to tune for; as many others are drawn for the trials.",
)
@click.option(
    "--spread",
    "spread_percent",
    type=Amount("PERCENT"),
    default="20 %",
    show_default=True,
    help="Largest deviation of the random machines' capacities and resistances.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Random seed.")
@click.option("--plot", type=File, metavar="OUT", help="Draw Bode diagram and trial: .png or .svg.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    asked: tuple[str, ...],
    loops: tuple[str, ...],
    log: Path | None,
    at_c: float | None,
    lambda_s: float | None,
    tauc_s: float | None,
    is_robust: bool,
    machines: int,
    spread_percent: float,
    seed: int,
    plot: Path | None,
    as_json: bool,
) -> int:
    """Find the gains of a PID.

    relay is the experiment that the firmware does by command, here on the simulated machine; simc
    and lambda are rules for the machine's model. Each method's gains are judged by the margins of
    the sampled loop and tried from cold in a simulation, as are the spec's own. The output is YAML
    to paste: the gains of the first method whose Ms is at most 2 and whose trial trips nothing; if
    there is none, the best of the others, with a warning. The exit status is 1 if a loop gets no
    gains. Loops are tuned one after the other; all others stay as they are after power-up.

    --log takes the machine from a recorded step, as identify fits it, with one body.

    --robust begins with the best of these gains, and improves them for machines whose capacities,
    resistances, ambient and supply differ from the spec's: the worst machine's result decides. All
    methods are then tried on other machines, drawn in the same way.
    """
    check_target(plot, PICTURES)
    for name, value in (("--lambda", lambda_s), ("--tauc", tauc_s)):
        if value is not None and value <= 0:
            raise Refused(f"{name}: must be above 0.")
    if not 0 < spread_percent <= MOST_SPREAD_PERCENT:
        raise Refused(f"--spread: must be above 0 %, and at most {MOST_SPREAD_PERCENT:g} %.")
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.cli.tune.task import plan_of  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    if log is not None:
        from heatwright.cli.tune.recorded import with_machine_of  # noqa: PLC0415

        loaded = with_machine_of(spec, loaded, log)
    plan = plan_of(loaded, loops, asked, METHODS, at_c=at_c, lambda_s=lambda_s, tauc_s=tauc_s)
    wish = _wish(machines, spread_percent, seed) if is_robust else None
    with talk() as shown:
        found = [_tuned(job, wish, shown) for job in plan.jobs]
    if plot is not None:
        _draw(found, plot)
    if as_json:
        _print_json(spec, loaded, found, plan)
    else:
        _print(found, plan, plot)
    return Status.FAILED if any(each.chosen is None for each in found) else Status.DONE


class _Tuned(NamedTuple):
    """The results of tuning one loop."""

    task: Task
    rows: Sequence[Judged | Failed]
    good: Sequence[Judged]
    tried: Mapping[str, Tried]
    chosen: Judged | None
    doubt: str | None
    """Why the chosen gains should not be used as they are."""
    trade: Trade | None


def _wish(machines: int, spread_percent: float, seed: int) -> Wish:
    from heatwright.cli.tune.robust import Wish  # noqa: PLC0415
    from heatwright.sim.tuning.robust import Spread  # noqa: PLC0415

    return Wish(machines, Spread(spread_percent / 100), seed)


def _tuned(job: Job, wish: Wish | None, shown: Talk) -> _Tuned:
    from heatwright.cli.tune.methods import Judged, find, proposed, try_all  # noqa: PLC0415
    from heatwright.cli.tune.tabled import doubt  # noqa: PLC0415

    rows, trade, able = find(job.task, job.methods, shown), None, job.methods
    if wish is not None:
        from heatwright.cli.tune.robust import robust  # noqa: PLC0415

        row, trade = robust(job.task, rows, wish, shown)
        rows, able = [*rows, row], (row.method,)
    good = [row for row in rows if isinstance(row, Judged)]
    tried = try_all(job.task, good, shown)
    chosen = proposed([row for row in good if row.method in able], tried)
    warned = None if chosen is None else doubt(chosen, tried[chosen.method])
    return _Tuned(job.task, rows, good, tried, chosen, warned, trade)


def _print(found: Sequence[_Tuned], plan: Plan, plot: Path | None) -> None:
    for each in found:
        _print_loop(each, named=len(each.task.controller.loops) > 1)
    for loop, why in plan.skipped.items():
        click.echo(f"Loop {loop} is left out: {why}")
    if plot is not None:
        click.echo(str(plot))


def _print_loop(found: _Tuned, *, named: bool) -> None:
    from heatwright.cli.results import fault_text  # noqa: PLC0415
    from heatwright.cli.tables import heading, show, table  # noqa: PLC0415
    from heatwright.cli.tune.methods import Failed  # noqa: PLC0415
    from heatwright.cli.tune.tabled import COLUMNS, block, legend, line  # noqa: PLC0415

    task, tried = found.task, found.tried
    heading(f"{task.controller.identity.name}, loop {task.loop}")
    show(table(COLUMNS, [line(row, tried.get(row.method)) for row in found.rows]))
    for text in legend(task):
        click.echo(f"  {text}")
    for row in found.rows:
        if isinstance(row, Failed):
            click.secho(f"  {row.method}: no gains: {row.reason}", fg="red")
        elif row.method in tried:
            for fault in tried[row.method].faults:
                click.secho(f"  {row.method}: {fault_text(fault)}", fg="red")
    if found.trade is not None:
        _print_trade(task, found.trade)
    if found.chosen is not None:
        if found.doubt:
            click.secho(f"  {found.doubt}", fg="yellow")
        click.echo(f"\n{block(found.chosen, task.loop if named else '')}" + "\n" * named, nl=False)


def _print_trade(task: Task, trade: Trade) -> None:
    from heatwright.cli.tables import show, table  # noqa: PLC0415
    from heatwright.cli.tune import robust  # noqa: PLC0415

    show(table(robust.COLUMNS, [robust.line(row) for row in trade.rows]))
    for text in robust.legend(task, trade):
        click.echo(f"  {text}")


def _print_json(spec: Path, loaded: Spec, found: Sequence[_Tuned], plan: Plan) -> None:
    from heatwright.cli.tune import robust  # noqa: PLC0415
    from heatwright.cli.tune.tabled import block, model_json, rows_json  # noqa: PLC0415

    print_json(
        spec=str(spec),
        digest=loaded.digest,
        loops={
            each.task.loop: {
                "at": each.task.target_c,
                "model": model_json(each.task),
                "methods": rows_json(each.rows, each.tried),
                "chosen": None if each.chosen is None else each.chosen.method,
                "doubt": each.doubt,
                "yaml": None if each.chosen is None else block(each.chosen),
                "robust": each.trade and robust.as_json(each.trade),
            }
            for each in found
        },
        skipped=plan.skipped,
    )


def _draw(found: Sequence[_Tuned], plot: Path) -> None:
    from heatwright.cli.tune.figure import tuned_figure  # noqa: PLC0415
    from heatwright.sim.plots.plot import save  # noqa: PLC0415

    with whole(plot) as fresh:
        save(tuned_figure([(each.task, each.good, each.tried) for each in found]), fresh)
