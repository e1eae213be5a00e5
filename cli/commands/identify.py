"""`heatwright identify`: fits a plant to a recorded step."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import Amount, File, json_option, print_json, with_examples
from heatwright.cli.targets import check_target, whole

if TYPE_CHECKING:
    from heatwright.cli.identify.asked import Asked
    from heatwright.sim.identify import Identified

PICTURES = (".png", ".svg")


@with_examples(
    "heatwright identify oven.csv --power 240W --plot oven.png",
    "heatwright identify plotter.log --spec oven.yaml",
    "heatwright identify step.csv --spec oven.yaml --port /dev/ttyUSB0 --for 40min",
    "heatwright identify log.txt --columns temperature,-,duty --full 255 --period 1s --power 40W",
)
@click.argument("log", type=File)
@click.option("--spec", type=File, help="Take names, power and period from this spec.")
@click.option(
    "--loop", help="The loop of the spec that LOG records; needed if the spec has several loops."
)
@click.option(
    "--columns",
    help="The columns in their order: time, temperature, duty, power, or - for one to ignore; "
    "or by name or number, such as duty=5.",
)
@click.option("--power", type=Amount("POWER"), help="Power at full duty, such as 40W.")
@click.option(
    "--full", type=click.FloatRange(min=0, min_open=True), help="LOG's duty at full power: 1, 255 …"
)
@click.option("--period", type=Amount("DURATION"), help="Time between two lines if LOG has none.")
@click.option(
    "--ambient", type=Amount("TEMPERATURE"), help="Ambient temperature; by default it is fitted."
)
@click.option("--cold", is_flag=True, help="All of the machine was at ambient when LOG began.")
@click.option(
    "--bodies",
    type=click.IntRange(1, 2),
    default=1,
    show_default=True,
    help="Fit one body, or one with a shell around it.",
)
@click.option("--port", metavar="PORT", help="First record LOG from the board at this serial port.")
@click.option("--for", "for_s", type=Amount("DURATION"), help="How long to record.")
@click.option("-o", "--output", type=File, metavar="OUT", help="Write the YAML to this file.")
@click.option("--plot", type=File, metavar="OUT", help="Draw record and fit: .png or .svg.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    log: Path,
    spec: Path | None,
    loop: str | None,
    columns: str | None,
    power: float | None,
    full: float | None,
    period: float | None,
    ambient: float | None,
    cold: bool,
    bodies: int,
    port: str | None,
    for_s: float | None,
    output: Path | None,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Fit a plant to a recorded step.

    The log is CSV, or what a serial plotter or a printer's host has recorded; lines without
    readings are skipped. The heater must have been switched during the record, which best begins
    and ends at a steady temperature. The output is YAML to paste into a spec, with the fit error,
    the 95 % interval of each number, and warnings for numbers that the record does not determine.

    With --port the step is recorded first, and written to LOG as `plot --record` does it. Ctrl-C
    ends the recording early.
    """
    if spec is None and loop is not None:
        raise Refused("--loop names a loop of a spec: give the spec, too, with --spec.")
    _check_scales(power, period)
    check_target(output)
    check_target(plot, PICTURES)
    if port is None and for_s is not None:
        raise Refused("--for is the time to record a serial line: name the line with --port.")
    from heatwright.cli.identify.asked import asked_of  # noqa: PLC0415
    from heatwright.spec.loading.user_file import read_file  # noqa: PLC0415

    data = read_file(log) if port is None else b""
    asked = asked_of(
        spec, loop, columns=columns, power_w=power, full=full, period_s=period, bodies=bodies
    )
    if port is not None:
        _record(log, spec, asked, port, for_s)
        data = read_file(log)
    found = _identify(log, data, asked, ambient, cold)
    from heatwright.cli.identify.block import as_json as block_json  # noqa: PLC0415
    from heatwright.cli.identify.block import block  # noqa: PLC0415

    text = block(found, log.name)
    if output is not None:
        with whole(output) as fresh:
            fresh.write_text(text, encoding="utf-8")
    if plot is not None:
        _draw(found, log.name, plot)
    if as_json:
        print_json(log=str(log), **block_json(found), yaml=text)
    elif output is None:
        click.echo(text, nl=False)
    if not as_json:
        for file in filter(None, (output, plot)):
            click.echo(str(file), err=output is None)


def _record(log: Path, spec: Path | None, asked: Asked, port: str, for_s: float | None) -> None:
    """Record a serial line, after a check that the record will have the columns of --columns."""
    if spec is None or for_s is None:
        raise Refused("--port needs also --spec, the board's spec, and --for, how long to record.")
    from heatwright.cli.plot.hearing import hearing_of  # noqa: PLC0415
    from heatwright.cli.plot.listener import HEAD, opened, record  # noqa: PLC0415
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.sim.identify import Unusable, read_log  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    try:
        asked.roles(read_log(f"{HEAD}0,0,0,0\n".encode()))
    except Unusable as error:
        raise Refused(f"{log}: {error}.") from None
    loaded = load(spec)
    hearing = hearing_of(loaded.file_name, loaded.controller, asked.loop)
    with opened(port, hearing) as line, talk() as shown:
        job = shown.begin(f"Recording {hearing.loop} from {port}")
        job.end(f"{record(line, hearing, log, for_s, job)} readings in {log}")


def _check_scales(power_w: float | None, period_s: float | None) -> None:
    for name, value in (("--power", power_w), ("--period", period_s)):
        if value is not None and value <= 0:
            raise Refused(f"{name}: must be above 0.")


def _identify(
    log: Path, data: bytes, asked: Asked, ambient_c: float | None, cold: bool
) -> Identified:
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.sim.identify import Unusable, fit  # noqa: PLC0415

    try:
        with talk() as shown:
            job = shown.begin("Reading the log")
            record = asked.record(data)
            job.end(f"{record.rows} readings")
            fitting = shown.begin("Fitting")
            return fit(
                record,
                asked.structure,
                ambient_c=ambient_c,
                age_s=asked.age_s,
                cold=cold,
                progress=fitting,
            )
    except Unusable as error:
        text = str(error)
        raise Refused(f"{log}: {text}{'' if text.endswith(('?', '…')) else '.'}") from None


def _draw(found: Identified, name: str, plot: Path) -> None:
    from heatwright.cli.identify.figure import identified_figure  # noqa: PLC0415
    from heatwright.sim.plots.plot import save  # noqa: PLC0415

    with whole(plot) as fresh:
        save(identified_figure(found, name), fresh)
