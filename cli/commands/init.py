"""`heatwright init`: a spec to begin with."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from shlex import quote

import click

from heatwright.cli.command import Command
from heatwright.cli.ends import Refused
from heatwright.cli.options import File, json_option, print_json
from heatwright.cli.targets import blaming


@click.command(
    cls=Command,
    examples=("heatwright init heater.yaml",),
)
@click.argument("file", type=File, default=Path("controller.yaml"))
@json_option
def command(file: Path, as_json: bool) -> None:
    """Write a commented spec to start from.

    FILE is controller.yaml if none is named. The spec is complete: check, generate and verify take
    it as it is. A file that is there already is left alone.
    """
    text = starter(_name(file), quote(file.name) if file.name.isprintable() else "SPEC")
    try:
        with blaming(file):
            target = file.open("x", encoding="utf-8")
    except FileExistsError:
        raise Refused(f"{file}: is there already and stays as it is; name another file.") from None
    try:
        with blaming(file), target:
            target.write(text)
    except BaseException:
        file.unlink(missing_ok=True)
        raise
    if as_json:
        print_json({"file": str(file)})
    else:
        click.echo(f"{file}: written. Next: heatwright check {quote(str(file))}")


def starter(name: str, file: str) -> str:
    """Return the text of the spec, for a controller of this name; `file`: in commands."""
    text = files("heatwright.cli").joinpath("starter.yaml").read_text(encoding="utf-8")
    return text.replace("NAME", name).replace("FILE", file)


def _name(file: Path) -> str:
    """Make the controller's name from the file's: what is no letter or digit becomes `_`."""
    from heatwright.spec.names import check_name  # noqa: PLC0415

    name = re.sub(r"[^a-z0-9]+", "_", file.stem.lower()).strip("_")
    try:
        check_name(name)
    except Exception:
        return "controller"
    return name
