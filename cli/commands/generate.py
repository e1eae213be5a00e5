"""`heatwright generate`: writes the C of a spec to a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Status
from heatwright.cli.options import File, json_option, print_json, spec_argument, with_examples
from heatwright.cli.targets import blaming

if TYPE_CHECKING:
    from heatwright.spec import Spec


@with_examples(
    "heatwright generate chamber.yaml", "heatwright generate chamber.yaml -o firmware --check"
)
@spec_argument
@click.option(
    "-o",
    "--output",
    "folder",
    metavar="DIR",
    type=File,
    help="Folder of the firmware.  [default: generated/NAME, NAME as in the spec]",
)
@click.option(
    "--check", is_flag=True, help="Write nothing; exit with 1 if the folder is not up to date."
)
@json_option
def command(spec: Path, folder: Path | None, check: bool, as_json: bool) -> int:
    """Generate the firmware of a spec.

    It is a PlatformIO project, and a sketch for the Arduino IDE. The same spec gives the same
    bytes. Files that heatwright did not write are never changed.
    """
    from heatwright.generator import plan_firmware, render  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    files = render(plan_firmware(loaded))
    target = folder or Path("generated") / loaded.controller.identity.name
    return (_compare if check else _write)(loaded, files, target, as_json)


def _write(spec: Spec, files: Mapping[str, str], folder: Path, as_json: bool) -> int:
    from heatwright.generator import write  # noqa: PLC0415
    from heatwright.generator.output import left_over  # noqa: PLC0415

    with blaming(folder):
        written = [path.relative_to(folder).as_posix() for path in write(files, folder)]
    extra = left_over(files, folder)
    if as_json:
        print_json(
            folder=str(folder),
            digest=spec.digest,
            files=list(files),
            written=written,
            left_over=list(extra),
        )
        return Status.DONE
    changed = f"{len(written)} written" if written else "all up to date"
    click.echo(f"{folder}: {len(files)} files, {changed}")
    for path in extra:
        click.echo(f"{folder / path}: no longer generated; delete it.", err=True)
    return Status.DONE


def _compare(spec: Spec, files: Mapping[str, str], folder: Path, as_json: bool) -> int:
    from heatwright.generator import compare  # noqa: PLC0415

    differences = compare(files, folder)
    if as_json:
        print_json(
            folder=str(folder),
            digest=spec.digest,
            differences=[{"path": each.path, "state": each.state} for each in differences],
        )
    elif differences:
        for each in differences:
            click.echo(f"{folder / each.path}: {each.state}")
    else:
        click.echo(f"{folder}: up to date")
    return Status.FAILED if differences else Status.DONE
