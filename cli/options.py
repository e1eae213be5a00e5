"""What the commands share: a help that ends with examples, arguments and options."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from heatwright.cli.ends import JSON_TOLD


class Command(click.Command):
    """A command whose help lists examples, one on each line, below the options."""

    def __init__(self, *arguments: Any, examples: tuple[str, ...] = (), **names: Any) -> None:
        super().__init__(*arguments, **names)
        self.examples = examples

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples."""
        super().format_epilog(ctx, formatter)
        with formatter.section("Examples" if len(self.examples) > 1 else "Example"):
            for line in self.examples:
                formatter.write(f"{'':{formatter.current_indent}}{line}\n")


def with_examples(*examples: str) -> Callable[[Callable[..., Any]], Command]:
    """Make a function a command; its help ends with the examples."""
    return click.command(cls=Command, examples=examples)


PLOTS = (".png", ".svg", ".html")
"""Suffixes of the files that a plot can be written to."""


class _File(click.Path):
    """A path; an empty one is refused, as it would mean the working folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("the name is empty.", param, ctx)
        return super().convert(value, param, ctx)


File = _File(readable=False, path_type=Path)
"""Click does not check whether the file can be read: reading it shows that."""

spec_argument = click.argument("spec", type=File)

json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object instead of text."
)


def print_json(**members: object) -> None:
    """Print one JSON object; a number that JSON cannot hold (NaN) is an error."""
    from json import dumps  # noqa: PLC0415 - only with --json

    text = dumps(members, indent=2, ensure_ascii=False, allow_nan=False)
    click.get_current_context().ensure_object(dict)[JSON_TOLD] = True
    click.echo(text)


class Length(click.ParamType[float]):
    """The length of a scenario with its unit, as in a spec; gives seconds."""

    name = "duration"

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the length in s, or fail with the message that a spec gets."""
        if not isinstance(value, str):
            return value
        from heatwright.cli.beside import read_length  # noqa: PLC0415

        try:
            return read_length(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Amount(click.ParamType[float]):
    """A quantity with its unit, as in a spec; gives its value in the base unit."""

    def __init__(self, dimension: str) -> None:
        """Name the dimension as in `heatwright.spec.units`, such as POWER."""
        self._dimension = dimension
        self.name = dimension.lower()

    def convert(
        self, value: str | float, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the value in the base unit, or fail with the message that a spec gets."""
        if not isinstance(value, str):
            return value
        from pydantic_core import PydanticCustomError  # noqa: PLC0415

        from heatwright.spec import quantity, units  # noqa: PLC0415

        try:
            return quantity.parse(value, getattr(units, self._dimension))
        except PydanticCustomError as error:
            told = error.context or {}
            self.fail(f"{told['reason']}. {told['remedy']}.", param, ctx)
