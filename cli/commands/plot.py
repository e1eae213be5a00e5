"""`heatwright plot`: draws a loop's signals over time, from a serial line or a recorded log."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli import ports
from heatwright.cli.ends import Refused
from heatwright.cli.options import File, json_option, spec_argument, with_examples

if TYPE_CHECKING:
    from heatwright.cli.bench.server import Server
    from heatwright.cli.plot.listener import Shown
    from heatwright.spec import Spec


@with_examples(
    "heatwright plot oven.yaml --open",
    "heatwright plot oven.yaml --port /dev/ttyUSB0 --record step.csv",
    "heatwright plot oven.yaml --log step.csv --open",
)
@spec_argument
@click.option("--port", metavar="PORT", help="Serial port, such as /dev/ttyUSB0 or COM3.")
@click.option("--log", type=File, metavar="LOG", help="Draw this recorded log, not a live line.")
@click.option(
    "--loop",
    metavar="NAME",
    help="The loop to show; by default the first one whose readings the line sends. "
    "With --log it is needed if the spec has several.",
)
@click.option("--record", type=File, metavar="OUT", help="Also write the readings to this CSV.")
@click.option("--open", "opens", is_flag=True, help="Open the page in the browser.")
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    port: str | None,
    log: Path | None,
    loop: str | None,
    record: Path | None,
    opens: bool,
    as_json: bool,
) -> None:
    """Draw a loop's course, from a serial line or a log.

    It listens to the lines of a serial_plotter, or asks a G-code firmware (M105), a Modbus slave
    (registers) or a serial_log (entries), at the baud rate of the spec. The chart is that of bench.
    The file of --record can be given to identify, tune and plot. With --log the command shows what
    was recorded before, in any form that identify reads.

    Only this computer can open the page, at an address that nobody can guess. Ctrl-C ends it. Most
    boards restart when their port is opened.
    """
    if log is not None and (port is not None or record is not None):
        raise Refused("--log replaces the serial line: leave out --log, or --port and --record.")
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    if log is not None:
        server = _announced(_of_log(spec, loaded, log, loop), opens, as_json)
        with suppress(KeyboardInterrupt):
            server.run()
        return
    from heatwright.cli.plot.hearing import hearing_of  # noqa: PLC0415
    from heatwright.cli.plot.listener import Record, opened  # noqa: PLC0415

    hearing = hearing_of(loaded.file_name, loaded.controller, loop)
    with opened(port or ports.found(), hearing) as line:
        file = None if record is None else Record(record)
        source = f"{hearing.kind} on {line.name}, {hearing.line.baud} baud"
        shown = _shown(loaded, hearing.loop, source, live=True)
        try:
            # The server must exist before the thread listens: a line that fails at once stops it.
            server = _announced(shown, opens, as_json)
            shown.listen(line, hearing, file)
            with suppress(KeyboardInterrupt):
                server.run()
        finally:
            shown.stop()
            if file is not None:
                file.close()
    if shown.failed is not None:
        raise shown.failed


def _of_log(spec: Path, loaded: Spec, log: Path, loop: str | None) -> Shown:
    from heatwright.cli.identify.asked import asked_of  # noqa: PLC0415
    from heatwright.cli.plot.course import course_of  # noqa: PLC0415
    from heatwright.sim.identify import Unusable  # noqa: PLC0415
    from heatwright.spec.loading.user_file import read_file  # noqa: PLC0415

    data = read_file(log)
    asked = asked_of(spec, loop, columns=None, power_w=None, full=None, period_s=None, bodies=1)
    try:
        readings = course_of(asked, data)
    except Unusable as error:
        raise Refused(f"{log}: {error}.") from None
    shown = _shown(loaded, asked.loop, str(log), live=False)
    shown.tell(readings)
    return shown


def _shown(loaded: Spec, loop: str, source: str, *, live: bool) -> Shown:
    from heatwright.cli.plot.listener import Shown  # noqa: PLC0415

    identity = loaded.controller.identity
    about = {"title": identity.title or identity.name, "loop": loop, "source": source, "live": live}
    return Shown(about, loop)


def _announced(shown: Shown, opens: bool, as_json: bool) -> Server:
    """Bind a server, and print the address of its page."""
    from heatwright.cli.bench.server import Server  # noqa: PLC0415
    from heatwright.cli.commands.bench import announce  # noqa: PLC0415

    server = Server(shown)
    announce(server.address, as_json)
    if opens:
        click.launch(server.address)
    return server
