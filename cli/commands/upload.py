"""`heatwright upload`: writes the verified binary to a board."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING

import click

from heatwright.cli import ports
from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware, told_as_json
from heatwright.cli.options import json_option, print_json, spec_argument, with_examples
from heatwright.cli.talk import talk

if TYPE_CHECKING:
    from heatwright.spec import Board

_LAST_LINES = 3


@with_examples("heatwright upload chamber.yaml", "heatwright upload dryer.yaml --programmer usbasp")
@spec_argument
@click.option("--port", metavar="PORT", help="Serial port, such as /dev/ttyUSB0 or COM3.")
@click.option("--programmer", metavar="NAME", help="Programmer at the ISP header.")
@json_option
def command(spec: Path, port: str | None, programmer: str | None, as_json: bool) -> None:
    """Build the firmware and write it to the board with avrdude.

    It is the same binary that `verify` tests. Switch the heater's supply off before the first time.
    """
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    board = loaded.controller.board
    if board.bootloader_talks is None and programmer is None:
        raise Refused(
            f"{spec}: {board.name} is a bare chip, without a boot loader: name the programmer at "
            "its ISP header, such as --programmer usbasp."
        )
    avrdude = _avrdude()
    with told_as_json(as_json, spec, loaded), talk() as shown:
        built = build_firmware(loaded, shown.begin(f"Building {loaded.controller.identity.name}"))
        if programmer is None and port is None:
            port = _waited(board)
        job = shown.begin(f"Writing to {board.name}")
        _write(_words(avrdude, board, port, programmer), built.elf.with_suffix(".hex"))
        job.end("written")
    if as_json:
        print_json(
            spec=str(spec),
            digest=loaded.digest,
            board=board.name,
            port=port,
            programmer=programmer,
            file=str(built.elf.with_suffix(".hex")),
        )
    else:
        speaks = any(each.line is not None for each in loaded.controller.interfaces)
        following = f"heatwright monitor {spec}" if speaks else "Commissioning, in its README"
        click.echo(f"{board.name}: written. Next: {following}")


def _avrdude() -> str:
    """Find avrdude: the system's, or the one that PlatformIO has downloaded."""
    from heatwright.generator.toolchain import ToolMissing  # noqa: PLC0415

    core = Path(os.environ.get("PLATFORMIO_CORE_DIR", Path.home() / ".platformio"))
    found = which("avrdude") or which("avrdude", path=str(core / "packages" / "tool-avrdude"))
    if found is None:
        raise ToolMissing("avrdude is missing: sudo apt-get install avrdude")
    return found


def _waited(board: Board) -> str:
    resets = board.name == "leonardo"
    if resets:
        click.echo("Press the reset button of the board now.", err=True)
    return ports.found(waits=resets)


def _words(avrdude: str, board: Board, port: str | None, programmer: str | None) -> list[str]:
    """Return avrdude's command without the file; -D keeps the boot loader in the flash."""
    words = [avrdude, "-q", "-p", board.mcu]
    if programmer is not None:
        words += ["-c", programmer]
    elif board.bootloader_talks is not None:
        protocol, baud = board.bootloader_talks
        words += ["-c", protocol, "-b", str(baud), "-D"]
    return words if port is None else [*words, "-P", port]


def _write(words: list[str], file: Path) -> None:
    done = subprocess.run(  # noqa: S603
        [*words, "-U", f"flash:w:{file}:i"], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        raise Refused(
            "avrdude could not write to the board. Is it plugged in, is it the board of the spec, "
            "and does no other program use its port? avrdude said:\n  "
            + "\n  ".join(said[-_LAST_LINES:])
        )
