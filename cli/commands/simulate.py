"""`heatwright simulate`: runs a spec in closed loop with its simulated machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import PLOTS, File, Length, json_option, spec_argument, with_examples
from heatwright.cli.targets import check_target

if TYPE_CHECKING:
    from heatwright.cli.running import Run
    from heatwright.spec import Controller, Spec


@with_examples(
    "heatwright simulate chamber.yaml --plot chamber.html",
    "heatwright simulate chamber.yaml --model --for 2h --csv chamber.csv",
    "heatwright simulate kiln.yaml --display kiln.png",
    "heatwright simulate extruder.yaml --serial",
)
@spec_argument
@click.option("--scenario", type=File, help="Take the scenario from this file.")
@click.option("--for", "length_s", type=Length(), help="How long to simulate, such as 2h.")
@click.option("--model", is_flag=True, help="Simulate the reference model, not the binary.")
@click.option("--plot", type=File, metavar="OUT", help="Draw the run: .png, .svg or .html.")
@click.option("--csv", type=File, metavar="OUT", help="Write all temperatures and variables.")
@click.option("--vcd", type=File, metavar="OUT", help="Write the activity of the pins used.")
@click.option("--display", type=File, metavar="OUT", help="Draw the touch display's page: .png.")
@click.option("--serial", is_flag=True, help="Run in real time, with a port that a host can open.")
@click.option(
    "--speed",
    type=click.FloatRange(0.01, 1000),
    default=1.0,
    help="With --serial: how many times faster than real time.",
)
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    scenario: Path | None,
    length_s: float | None,
    model: bool,
    plot: Path | None,
    csv: Path | None,
    vcd: Path | None,
    display: Path | None,
    serial: bool,
    speed: float,
    as_json: bool,
) -> None:
    """Run the firmware against the simulated machine.

    The firmware is generated, built, and run unmodified in a simulated processor, with sensor,
    display, keys and heater at its pins. A scenario file has the key `scenario:` and its list of
    events, as in a spec.

    With --serial no scenario is played: the board waits for a host (Printrun, OctoPrint, a
    terminal), a Modbus master or a Nextion editor at the port whose name is printed, until Ctrl-C.
    A master must open this port without parity, whatever the spec says: it does not support parity.
    """
    from heatwright.spec import facts_of, load  # noqa: PLC0415

    if serial:
        if model or any((scenario, plot, csv, vcd, display)):
            raise Refused("--serial can be combined with --speed, --for and --json only.")
        from heatwright.cli.live import serve  # noqa: PLC0415

        serve(load(spec), speed=speed, until_s=length_s, as_json=as_json)
        return
    if model and vcd is not None:
        raise Refused("The model has no pins: leave out --vcd or --model.")
    if model and display is not None:
        raise Refused("The model has no display: leave out --display or --model.")
    check_target(plot, PLOTS)
    check_target(csv)
    check_target(vcd)
    check_target(display, (".png",))
    from heatwright.cli.beside import with_scenario  # noqa: PLC0415
    from heatwright.cli.targets import whole  # noqa: PLC0415

    loaded = load(spec)
    controller = with_scenario(loaded, scenario, length_s)
    if display is not None and facts_of(controller).nextion is None:
        raise Refused("There is no touch display to draw: the spec has no interface nextion.")
    run = _simulate(loaded, controller, model, vcd)
    from heatwright.cli import results  # noqa: PLC0415

    device = "model" if model else "binary"
    results.write_run(run, controller, device, plot, csv)
    if display is not None and run.screen is not None:
        with whole(display) as fresh:
            fresh.write_bytes(run.screen)
    if as_json:
        results.print_run_json(str(spec), loaded, run, device)
    else:
        results.print_run(run, loaded, device)
        for file in filter(None, (plot, csv, vcd, display)):
            click.echo(str(file))


def _simulate(spec: Spec, controller: Controller, model: bool, vcd: Path | None) -> Run:
    from contextlib import nullcontext  # noqa: PLC0415

    from heatwright.cli.firmware import build_firmware  # noqa: PLC0415
    from heatwright.cli.running import run_binary, run_model  # noqa: PLC0415
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.cli.targets import whole  # noqa: PLC0415

    with talk() as shown:
        if model:
            return run_model(controller, shown.begin("Simulating the model"))
        built = build_firmware(spec, shown.begin("Building the firmware"))
        job = shown.begin("Simulating the binary")
        with whole(vcd) if vcd is not None else nullcontext() as fresh:
            return run_binary(controller, built.elf, job, fresh)
