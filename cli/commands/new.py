"""`heatwright new`: writes the stubs of a package that provides a kind."""

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import File, json_option, print_json, with_examples
from heatwright.cli.targets import blaming

STANDS_FOR = "newsensor"
"""The name of the kind in the stubs."""


@with_examples("heatwright new sensor max31865", "heatwright new sensor max31865 -o my_sensor")
@click.argument("role", type=click.Choice(["sensor"]))
@click.argument("name")
@click.option("-o", "--output", type=File, metavar="DIR", help="Folder of the package.")
@json_option
def command(role: str, name: str, output: Path | None, as_json: bool) -> None:
    """Write the stubs of a package that provides a kind of sensor.

    NAME is what a spec will call the kind. The package is installed beside heatwright with pip;
    `heatwright kinds` then lists what is still to be written, and in which file. Without --output
    the folder is heatwright-NAME. An existing folder is never changed.
    """
    _check(role, name)
    folder = output or Path(f"heatwright-{name}")
    if folder.exists():
        raise Refused(f"{folder}: exists already and is not changed; name another folder.")
    texts = dict(_stubs(files("heatwright.cli") / "stubs" / role, "", name))
    with blaming(folder):
        for path, text in texts.items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    if as_json:
        print_json(folder=str(folder), files=list(texts))
        return
    click.echo(f"{folder}: {len(texts)} files written.")
    click.echo(f"Next: pip install --editable {folder}; heatwright kinds")


def _check(role: str, name: str) -> None:
    """Refuse a name that C or Python does not allow, or that another kind has."""
    from heatwright.cli.contract import UNIONS  # noqa: PLC0415
    from heatwright.spec import kinds  # noqa: PLC0415
    from heatwright.spec.names import check_name  # noqa: PLC0415

    try:
        check_name(name)
    except Exception as error:
        raise Refused(f"{name} cannot be the name of a kind: {error}.") from None
    if name in kinds(UNIONS[role]):
        raise Refused(f"There is already a {role} of the kind {name}; choose another name.")


def _stubs(folder: Traversable, path: str, name: str) -> list[tuple[str, str]]:
    """Return path and text of each stub in a folder, written for the kind `name`."""
    found: list[tuple[str, str]] = []
    for each in sorted(folder.iterdir(), key=lambda entry: entry.name):
        inner = f"{path}{each.name}"
        if each.is_dir():
            found += _stubs(each, f"{inner}/", name) if each.name != "__pycache__" else []
        else:
            found.append((_named(inner, name), _named(each.read_text(encoding="utf-8"), name)))
    return found


def _named(text: str, name: str) -> str:
    camel = "".join(word.capitalize() for word in name.split("_"))
    return text.replace(STANDS_FOR.capitalize(), camel).replace(STANDS_FOR, name)
