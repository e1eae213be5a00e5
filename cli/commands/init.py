"""`heatwright init`: writes a first spec."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from heatwright.cli.ends import Refused
from heatwright.cli.options import File, json_option, print_json, with_examples
from heatwright.cli.targets import blaming

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from heatwright.cli.starters.composed import Choice

SCHEMA = "heatwright.schema.json"
"""The schema file that the first line of a spec names, for editors."""


def _completed(_: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the possible values of an option, for a shell's completion."""
    from heatwright.cli.starters.composed import choices, names  # noqa: PLC0415

    told = names(choices(), str(param.name))
    return [
        CompletionItem(each, help=about) for each, about in told.items() if each.startswith(begun)
    ]


class _Choice(click.Option):
    """An option whose help lists its values; they are read only when help is shown."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Add the values to the option's help."""
        from heatwright.cli.starters.composed import choices, names  # noqa: PLC0415

        shown = super().get_help_record(ctx)
        return shown and (shown[0], f"{shown[1]} {', '.join(names(choices(), str(self.name)))}.")


def _choice(kind: str, text: str) -> Callable[[Any], Any]:
    return click.option(
        f"--{kind}", cls=_Choice, metavar="NAME", shell_complete=_completed, help=text
    )


def _examples(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    return [CompletionItem(name) for name in _stems() if name.startswith(begun)]


@with_examples(
    "heatwright init heater.yaml",
    "heatwright init bath.yaml --machine sous_vide --interface modbus_rtu",
    "heatwright init mine.yaml --example fabricator",
)
@click.argument("file", type=File, default=Path("controller.yaml"))
@_choice("machine", "What is heated:")
@_choice("board", "What the firmware runs on:")
@_choice("sensor", "What measures the temperature:")
@_choice("output", "What switches the heater:")
@_choice("interface", "What displays and commands it:")
@click.option(
    "--example", metavar="NAME", shell_complete=_examples, help="Write a whole example instead."
)
@json_option
def command(file: Path, example: str | None, as_json: bool, **wanted: str | None) -> None:
    """Write a commented spec to start from.

    FILE is controller.yaml if none is named. In a terminal the command asks for what no option
    sets; otherwise it uses what is usual for the machine. The spec is complete: check, generate and
    verify accept it unchanged. The schema for editors is written beside it. No file is overwritten.
    """
    asks = sys.stdin is not None and sys.stdin.isatty()
    if asks and file.exists():
        raise _exists_already(file)
    given = {kind: name for kind, name in wanted.items() if name is not None}
    if example is not None:
        if given:
            other = next(iter(given))
            raise Refused(f"--example is a whole spec: leave out --{other} or --example.")
        text = _example(example, _name(file))
    else:
        text = _composed(file, given, asks=asks)
    _write(file, text)
    written = [file, *_with_schema(file)]
    if as_json:
        print_json(file=str(file), written=[str(each) for each in written])
    else:
        told = ", ".join(str(each) for each in written)
        click.echo(f"{told}: written. Next: heatwright check {quote(str(file))}")


def _composed(file: Path, given: dict[str, str], *, asks: bool) -> str:
    from heatwright.cli.starters.composed import Choice, choices, composed  # noqa: PLC0415

    left = choices()
    for kind, name in given.items():
        left = _narrowed(left, kind, name)
    for kind in Choice._fields if asks else ():
        if kind not in given:
            left = _narrowed(left, kind, _asked(left, kind))
    return composed(left[0], _name(file), quote(file.name) if file.name.isprintable() else "SPEC")


def _narrowed(left: list[Choice], kind: str, name: str) -> list[Choice]:
    from heatwright.cli.starters.composed import choices, names, narrowed  # noqa: PLC0415

    found = narrowed(left, kind, name)
    if found:
        return found
    able = ", ".join(names(left, kind))
    if name not in names(choices(), kind):
        raise Refused(f"--{kind}: there is no such {kind} as {name}. Use {able}.")
    raise Refused(
        f"--{kind}: init offers no such machine with {name}. Use {able}; or write {name} into the "
        "file afterwards: a spec may have more than init offers."
    )


def _asked(left: list[Choice], kind: str) -> str:
    """Ask in the terminal, unless only one value is left."""
    from heatwright.cli.starters.composed import names  # noqa: PLC0415

    told = names(left, kind)
    usual = next(iter(told))
    if len(told) == 1:
        return usual
    click.echo(f"\n{kind.capitalize()}:", err=True)
    for name, about in told.items():
        click.echo(f"  {name:<18}{about}".rstrip(), err=True)
    return str(
        click.prompt("Which?", usual, type=click.Choice(list(told)), show_choices=False, err=True)
    )


def _stems() -> list[str]:
    return sorted(each.name.removesuffix(".yaml") for each in _folder().iterdir())


def _folder() -> Traversable:
    return files("heatwright.spec").joinpath("examples")


def _example(wanted: str, name: str) -> str:
    """Return an example's text, for a controller of this name."""
    if wanted not in _stems():
        raise Refused(f"--example: there is no {wanted}. Use {', '.join(_stems())}.")
    text = _folder().joinpath(f"{wanted}.yaml").read_text(encoding="utf-8")
    renamed = text.replace(f"\n  name: {wanted}\n", f"\n  name: {name}\n", 1)
    return f"# yaml-language-server: $schema={SCHEMA}\n{renamed}"


def _with_schema(file: Path) -> list[Path]:
    """Write the schema beside a spec, unless one is there; return what was written."""
    schema_file = file.parent / SCHEMA
    if schema_file.exists():
        return []
    from json import dumps  # noqa: PLC0415

    from heatwright.spec.loading.schema import schema  # noqa: PLC0415

    _write(schema_file, dumps(schema(), indent=2, ensure_ascii=False) + "\n")
    return [schema_file]


def _exists_already(file: Path) -> Refused:
    return Refused(f"{file}: exists already and is not overwritten; name another file.")


def _write(file: Path, text: str) -> None:
    try:
        with blaming(file):
            target = file.open("x", encoding="utf-8")
    except FileExistsError:
        raise _exists_already(file) from None
    try:
        with blaming(file), target:
            target.write(text)
    except BaseException:
        file.unlink(missing_ok=True)
        raise


def _name(file: Path) -> str:
    """Make the controller's name from the file's: `_` replaces all but letters and digits."""
    from heatwright.spec.names import check_name  # noqa: PLC0415

    name = re.sub(r"[^a-z0-9]+", "_", file.stem.lower()).strip("_")
    try:
        check_name(name)
    except Exception:
        return "controller"
    return name
