"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path

import click

PLOTS = (".png", ".svg", ".html")
"""Kinds of file that a plot can be."""

File = click.Path(path_type=Path)

spec_argument = click.argument("spec", type=File)

json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object, for machines."
)


def print_json(value: object) -> None:
    """Print a value as JSON; numbers that are none of JSON's (NaN) are an error."""
    from json import dumps  # noqa: PLC0415 - only where asked for

    click.echo(dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


class Length(click.ParamType[float]):
    """The length of a scenario with its unit, as in a spec; gives seconds."""

    name = "duration"

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read it."""
        if not isinstance(value, str):
            return value
        from heatwright.cli.scenario import read_length  # noqa: PLC0415

        try:
            return read_length(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Amount(click.ParamType[float]):
    """A quantity with its unit, as in a spec; gives it in the base unit."""

    def __init__(self, dimension: str) -> None:
        """Name the dimension as in `heatwright.spec.units`, such as POWER."""
        self._dimension = dimension
        self.name = dimension.lower()

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read it."""
        if not isinstance(value, str):
            return value
        from pydantic_core import PydanticCustomError  # noqa: PLC0415

        from heatwright.spec import quantity, units  # noqa: PLC0415

        try:
            return quantity.parse(value, getattr(units, self._dimension))
        except PydanticCustomError as error:
            told = error.context or {}
            self.fail(f"{told['reason']}. {told['remedy']}.", param, ctx)
