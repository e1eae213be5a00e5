"""Arguments and options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])

File = click.Path(path_type=Path)

spec_argument = click.argument("spec", type=File)

json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object, for machines."
)


def model_option(help_text: str) -> Callable[[F], F]:
    """Make the option that takes the reference model for the binary."""
    return click.option("--model", is_flag=True, help=help_text)


def print_json(value: object) -> None:
    """Print a value as JSON; numbers that are none of JSON's (NaN) are an error."""
    from json import dumps  # noqa: PLC0415 - only where asked for

    click.echo(dumps(value, indent=2, ensure_ascii=False, allow_nan=False))
