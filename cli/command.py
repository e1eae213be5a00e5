"""A command whose help ends with examples."""

from collections.abc import Callable
from typing import Any

import click


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
