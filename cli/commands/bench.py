"""`heatwright bench`: shows the running firmware on a page in the browser."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import json_option, spec_argument, with_examples

if TYPE_CHECKING:
    from heatwright.cli.bench.board import Board
    from heatwright.cli.bench.server import Server


@with_examples(
    "heatwright bench chamber.yaml",
    "heatwright bench kiln.yaml --open --speed 10",
    "heatwright bench extruder.yaml --port 8080",
)
@spec_argument
@click.option("--open", "opens", is_flag=True, help="Open the page in the browser.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    help="The port on this computer; by default any free port.",
)
@click.option(
    "--speed",
    type=click.FloatRange(0.1, 1000),
    default=1.0,
    help="Speed at the start, in multiples of real time; the page can change it.",
)
@json_option
def command(spec: Path, opens: bool, port: int, speed: float, as_json: bool) -> None:
    """Run the firmware live, on a page to use it and to break it.

    The firmware is generated, built, and run unmodified in the simulated board, with all interfaces
    of the spec: keys and display, touch display, LEDs, serial lines, registers. The page draws the
    temperatures, has faults to switch on and off, and says why the heater is off. Your actions can
    be saved as a scenario for `simulate`.

    Only this computer can open the page, at an address that nobody can guess. Ctrl-C ends it.
    """
    from heatwright.cli.bench.board import Board  # noqa: PLC0415
    from heatwright.cli.firmware import build_firmware  # noqa: PLC0415
    from heatwright.cli.talk import talk  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    if loaded.controller.simulation is None:
        raise Refused("There is no machine to run against: the spec has no `simulation`.")
    with talk() as shown:
        built = build_firmware(loaded, shown.begin("Building the firmware"))
    board = Board(loaded.controller, built.elf, loaded.file_name, speed=speed)
    server = _bound(board, port)
    announce(server.address, as_json)
    if opens:
        click.launch(server.address)
    board.start()
    with suppress(KeyboardInterrupt):
        server.run()
    board.stop()
    if board.failed is not None:
        raise board.failed


def _bound(board: Board, port: int) -> Server:
    from heatwright.cli.bench.server import Server  # noqa: PLC0415

    try:
        return Server(board, port)
    except OSError as error:
        raise Refused(
            f"Port {port} cannot be opened: {error.strerror}. Leave out --port to use a free one."
        ) from None


def announce(address: str, as_json: bool) -> None:
    """Print the address of a page."""
    if as_json:
        from heatwright.cli.options import print_json  # noqa: PLC0415

        print_json(address=address)
    else:
        click.echo(f"{address}\nOpen it in a browser on this computer. Ctrl-C ends it.")
    sys.stdout.flush()
