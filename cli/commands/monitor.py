"""`heatwright monitor`: shows the data that a board sends on its serial line."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import click

from heatwright.cli import ports
from heatwright.cli.ends import Refused
from heatwright.cli.options import json_option, spec_argument, with_examples


@with_examples("heatwright monitor chamber.yaml")
@spec_argument
@click.option("--port", metavar="PORT", help="Serial port, such as /dev/ttyUSB0 or COM3.")
@json_option
def command(spec: Path, port: str | None, as_json: bool) -> int:
    """Show what the board sends on its serial line.

    It is PlatformIO's monitor, at the baud rate and parity of the spec's first serial line; what
    you type is sent.
    """
    del as_json  # only an error is printed as JSON
    from heatwright.generator.toolchain import ToolMissing  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    lines = [each.line for each in load(spec).controller.interfaces if each.line is not None]
    if not lines:
        raise Refused(f"{spec}: has no serial line; add an interface, such as serial_plotter.")
    line = min(lines, key=lambda each: each.port)
    if find_spec("platformio") is None:
        raise ToolMissing("PlatformIO is missing: pip install platformio")
    words = [sys.executable, "-m", "platformio", "device", "monitor"]
    words += ["--port", port or ports.found(), "--baud", str(line.baud)]
    return subprocess.call([*words, "--parity", line.parity[0].upper()])  # noqa: S603
