"""`heatwright campaign`: runs many machines of one spec, each drawn at random from a seed."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import (
    PLOTS,
    File,
    json_option,
    print_json,
    spec_argument,
    with_examples,
)
from heatwright.cli.targets import check_target, whole

if TYPE_CHECKING:
    from heatwright.cli.campaign.store import Store
    from heatwright.cli.campaign.work import Task
    from heatwright.cli.talk import Talk
    from heatwright.sim.campaign.outcome import Outcome
    from heatwright.sim.campaign.vary import Vary
    from heatwright.spec import Spec

MOST_RUNS = 100_000
INSTALL = "pip install 'heatwright[campaign]'"


@with_examples(
    "heatwright campaign chamber.yaml --runs 1000",
    "heatwright campaign chamber.yaml --vary workshop.yaml --report chamber.html",
    "heatwright campaign chamber.yaml --vary workshop.yaml --only 17 --plot 17.html",
    "heatwright campaign chamber.yaml --runs 100000 --scheduler tcp://10.0.0.5:8786",
)
@spec_argument
@click.option(
    "--runs",
    type=click.IntRange(1, MOST_RUNS),
    default=100,
    show_default=True,
    help="How many machines to run.",
)
@click.option(
    "--vary",
    "vary_file",
    type=File,
    metavar="FILE",
    help="File with the variations; by default variations that suit any machine.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    show_default=True,
    help="Seed of all random values.",
)
@click.option(
    "--only",
    type=click.IntRange(0, MOST_RUNS),
    metavar="RUN",
    help="Repeat only the run of this number, and show all its results.",
)
@click.option(
    "--plot", type=File, metavar="OUT", help="With --only: draw the run: .png, .svg or .html."
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=File,
    metavar="FOLDER",
    help="Folder of the results; by default the spec's name with .campaign.",
)
@click.option(
    "--report",
    type=File,
    metavar="OUT.html",
    help="Write distributions and worst runs as one HTML file.",
)
@click.option(
    "--processes",
    type=click.IntRange(1, 1024),
    metavar="N",
    help="Processes on this computer; by default one for each core.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Run on the workers of this Dask scheduler, such as tcp://10.0.0.5:8786.",
)
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    runs: int,
    vary_file: Path | None,
    seed: int,
    only: int | None,
    plot: Path | None,
    folder: Path | None,
    report: Path | None,
    processes: int | None,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Run the firmware on many machines, each drawn from a seed.

    Heat capacities and resistances, room, supply, sensors, operators, upsets and faults vary as the
    file of --vary says. Each run is saved as soon as it is done: after Ctrl-C the same command
    continues, and with more --runs only the missing runs are computed. The results are in
    runs.parquet in the folder.
    """
    check_target(report, (".html",))
    check_target(plot, PLOTS)
    if plot is not None and only is None:
        raise Refused("--plot draws a single run: give --only, too.")
    if only is not None and (report or scheduler or processes or folder):
        raise Refused("--only can be combined with --vary, --seed, --plot and --json only.")
    if only is None:
        _needs("pyarrow", *(["distributed"] if scheduler else []))
    from heatwright.cli.campaign.given import given  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    vary = given(loaded, vary_file)
    from heatwright.cli.firmware import told_as_json  # noqa: PLC0415
    from heatwright.cli.talk import talk  # noqa: PLC0415

    with told_as_json(as_json, spec, loaded), talk() as shown:
        task = _task(loaded, vary, seed, shown)
        began_s = perf_counter()
        if only is not None:
            one = _one(task, only, shown)
        else:
            place = folder or Path(f"{Path(loaded.file_name).stem}.campaign")
            store, computed = _all(task, place, runs, processes, scheduler, shown)
    if only is not None:
        _tell_one(spec, loaded, seed, one, plot, perf_counter() - began_s, as_json=as_json)
        return
    from heatwright.cli.campaign.shown import Campaign, print_summary, summary_json  # noqa: PLC0415
    from heatwright.cli.campaign.summary import summarised  # noqa: PLC0415

    rows = store.table(runs)
    done = Campaign(
        loaded, spec, vary, vary_file, seed, store.folder, store.write_table(rows), computed,
        perf_counter() - began_s, summarised(rows, tuple(loaded.controller.loops)),
    )  # fmt: skip
    if report is not None:
        from heatwright.cli.report.campaign_page import campaign_page  # noqa: PLC0415

        with whole(report) as fresh:
            fresh.write_text(campaign_page(done, rows), encoding="utf-8")
    if as_json:
        print_json(**summary_json(done))
        return
    print_summary(done)
    if report is not None:
        click.echo(str(report))


def _needs(*modules: str) -> None:
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        from heatwright.generator.toolchain.errors import ToolMissing  # noqa: PLC0415

        raise ToolMissing(f"A campaign needs {' and '.join(missing)}: {INSTALL}")


def _task(spec: Spec, vary: Vary, seed: int, shown: Talk) -> Task:
    from heatwright.cli.campaign.work import Task  # noqa: PLC0415
    from heatwright.cli.firmware import build_firmware  # noqa: PLC0415

    built = build_firmware(spec, shown.begin("Building the firmware"))
    return Task(spec.controller, vary, seed, built.elf.read_bytes())


def _one(task: Task, number: int, shown: Talk) -> Outcome:
    from heatwright.cli.campaign.work import run_whole  # noqa: PLC0415

    return run_whole(task.pack(), number, shown.begin("Simulating the run"), logs_nodes=True)


def _all(  # noqa: PLR0913, PLR0917 - the parts of a campaign
    task: Task, folder: Path, runs: int, processes: int | None, scheduler: str | None, shown: Talk
) -> tuple[Store, int]:
    from heatwright.cli.campaign.store import Store, identity  # noqa: PLC0415
    from heatwright.cli.campaign.work import run_here  # noqa: PLC0415

    store = Store(folder, identity(task))
    with store.opened():
        left = [number for number in range(runs) if number not in store.rows]
        job = shown.begin("Running")
        if left and scheduler is not None:
            from heatwright.cli.campaign.cluster import run_there  # noqa: PLC0415

            run_there(task.pack(), left, scheduler, store.keep, job)
        elif left:
            run_here(task.pack(), left, processes, store.keep, job)
        before = f"; {runs - len(left)} were done before" if len(left) < runs else ""
        job.end(f"{len(left)} runs{before}")
    return store, len(left)


def _tell_one(  # noqa: PLR0913, PLR0917 - the results of a run
    file: Path, spec: Spec, seed: int, one: Outcome, plot: Path | None, wall_s: float, *,
    as_json: bool,
) -> None:  # fmt: skip
    from heatwright.cli.campaign.shown import print_run, run_json  # noqa: PLC0415

    if plot is not None:
        from heatwright.cli.results import write_run  # noqa: PLC0415
        from heatwright.cli.running import Run  # noqa: PLC0415
        from heatwright.sim.plots.plot_data import faults  # noqa: PLC0415

        tripped = {loop: faults(log) for loop, log in one.trace.steps.items()}
        run = Run(one.trace, wall_s, dict(one.figures), tripped)
        write_run(run, spec.controller, f"binary, run {one.row['run']} of seed {seed}", plot, None)
    if as_json:
        print_json(**run_json(file, spec, seed, one))
        return
    print_run(spec, seed, one)
    if plot is not None:
        click.echo(str(plot))
