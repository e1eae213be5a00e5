"""Results of a simulation: figures on standard output, pictures and tables in files."""

from pathlib import Path

import click

from heatwright.cli.figures import as_json, rounded
from heatwright.cli.options import print_json
from heatwright.cli.running import Run
from heatwright.cli.targets import whole
from heatwright.sim.plots.plot_data import Tripped, fault_label
from heatwright.spec import RULES, Controller, Spec
from heatwright.spec.quantity import duration


def write_run(
    run: Run, controller: Controller, device: str, plot: Path | None, csv: Path | None
) -> None:
    """Write the files of --plot and --csv."""
    if csv is not None:
        with whole(csv) as fresh:
            run.trace.write_csv(fresh)
    if plot is None:
        return
    title = controller.identity.title or controller.identity.name
    with whole(plot) as fresh:
        if plot.suffix.lower() == ".html":
            from heatwright.cli.report.run_page import run_page  # noqa: PLC0415

            fresh.write_text(run_page(run, controller, title, device), encoding="utf-8")
        else:
            from heatwright.sim.plots.plot import run_figure, save  # noqa: PLC0415

            save(run_figure(run.trace, controller, title), fresh)


def print_run_json(file: str, spec: Spec, run: Run, device: str) -> None:
    """Print a run as JSON."""
    print_json(
        spec=file,
        digest=spec.digest,
        device=device,
        loops={
            loop: {
                "closed_loop": as_json(figures),
                "faults": [
                    {"time_s": rounded(time_s), "code": code, "rule": RULES[code].id}
                    for time_s, code in run.faults[loop]
                ],
            }
            for loop, figures in run.figures.items()
        },
        display=None if run.display is None else list(run.display),
        lights={loop: dict(shown) for loop, shown in run.lights.items()},
        not_done=None
        if run.not_done is None
        else [{"time_s": rounded(time_s), "answer": text} for time_s, text in run.not_done],
        speed=speed(run),
    )


def speed(run: Run) -> dict[str, float | None]:
    """Return the object `speed` of the JSON."""
    return {
        "simulated_s": rounded(run.trace.duration_s),
        "wall_s": rounded(run.wall_s),
        "awake_cycles_per_s": None if run.limit is None else rounded(run.limit.awake_per_s),
        "cycle_ns": None if run.limit is None else rounded(1e9 * run.limit.cycle_s),
    }


def speed_text(run: Run, what: str = "") -> str:
    """Say how fast the simulation was, and its limit; `what` names what was simulated."""
    fast = (
        f"{duration(round(run.trace.duration_s))}{what} simulated in {run.wall_s:.2f} s, "
        f"{run.speed:.0f} times faster than the machine"
    )
    if run.limit is None:
        return fast
    cycles, ns = run.limit.awake_per_s, 1e9 * run.limit.cycle_s
    return (
        f"{fast} (at most {run.limit.speed:.0f}: {cycles:,.0f} cycles awake in a second, "
        f"{ns:.1f} ns each)"
    )


def print_run(run: Run, spec: Spec, device: str) -> None:
    """Print a run as text."""
    from heatwright.cli.tables import console, heading, show_figures  # noqa: PLC0415

    out = console()
    heading(f"{spec.controller.identity.name}, the {device}")
    show_figures(run.figures)
    for loop, tripped in run.faults.items():
        for fault in tripped:
            out.print(f"  {loop}: {fault_text(fault)}", style="red", markup=False)
    if run.display is not None:
        click.echo("  display  " + "\n           ".join(f"|{row}|" for row in run.display))
    for loop, shown in run.lights.items():
        click.echo(f"  LEDs of {loop}: {', '.join(' '.join(each) for each in shown.items())}")
    for time_s, text in run.not_done or ():
        click.secho(f"  request at {time_s:.1f} s failed: {text}", fg="yellow")
    click.echo(f"  {speed_text(run)}")


def fault_text(fault: Tripped) -> str:
    """Write a fault as one line."""
    time_s, code = fault
    return f"fault {fault_label(code)} after {time_s:.1f} s: {RULES[code].meaning}"
