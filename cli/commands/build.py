"""`heatwright build`: makes the binary of a spec."""

from __future__ import annotations

from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware, told_as_json
from heatwright.cli.options import File, json_option, print_json, spec_argument, with_examples
from heatwright.cli.talk import talk
from heatwright.cli.targets import blaming, check_target, whole

if TYPE_CHECKING:
    from heatwright.generator.toolchain import BuildResult

SUFFIXES = (".elf", ".hex")


@with_examples("heatwright build chamber.yaml -o firmware")
@spec_argument
@click.option(
    "-o",
    "--output",
    "folder",
    metavar="DIR",
    type=File,
    help="Put NAME.elf and NAME.hex into this folder.",
)
@json_option
def command(spec: Path, folder: Path | None, as_json: bool) -> None:
    """Build the firmware with PlatformIO.

    Prints how much flash and RAM it takes. The stack is the worst case, computed from the machine
    code: the deepest chain of calls plus the deepest interrupt.
    """
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    name = loaded.controller.identity.name
    if folder is not None:
        _check(folder, name)
    with told_as_json(as_json, spec, loaded, files=[]), talk() as shown:
        built = build_firmware(loaded, shown.begin(f"Building {name}"))
    files = [built.elf] if folder is None else _delivered(built.elf, folder, name)
    if as_json:
        from heatwright.cli.figures import build_json  # noqa: PLC0415

        print_json(
            spec=str(spec),
            digest=loaded.digest,
            files=[str(file) for file in files],
            build=build_json(built),
        )
        return
    for line in lines(built):
        click.echo(line)
    for file in files:
        click.echo(str(file))


def lines(built: BuildResult) -> list[str]:
    """Return the sizes as lines of text."""
    free = built.ram_limit - built.ram_bytes - built.stack_bytes
    return [
        f"flash {built.flash_bytes:6d} of {built.flash_limit} bytes",
        f"RAM   {built.ram_bytes:6d} of {built.ram_limit} bytes, static",
        f"stack {built.stack_bytes:6d} bytes at worst; {free} bytes of RAM are never used",
    ]


def _check(folder: Path, name: str) -> None:
    """Refuse files that cannot be written, before the build."""
    if folder.is_dir():
        for suffix in SUFFIXES:
            check_target(folder / f"{name}{suffix}")
    elif folder.exists():
        raise Refused(f"{folder}: is a file; name a folder.")


def _delivered(elf: Path, folder: Path, name: str) -> list[Path]:
    with blaming(folder):
        folder.mkdir(parents=True, exist_ok=True)
    targets = []
    for suffix in SUFFIXES:
        target = folder / f"{name}{suffix}"
        with whole(target) as fresh:
            copyfile(elf.with_suffix(suffix), fresh)
        targets.append(target)
    return targets
