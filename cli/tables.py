"""Tables on standard output."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console, JustifyMethod, RenderableType
from rich.table import Table
from rich.text import Text

WIDE = 200
"""Columns where there is no terminal: whoever reads a file can scroll."""


def console() -> Console:
    """Return the console of standard output."""
    if sys.stdout.isatty():
        return Console(highlight=False)
    return Console(highlight=False, width=WIDE)


def heading(text: str) -> None:
    """Print a line above a table."""
    console().print(text, style="bold", markup=False)


def show(what: RenderableType) -> None:
    """Print something; lines in a file have no blanks at their ends."""
    out = console()
    if sys.stdout.isatty():
        out.print(what)
        return
    with out.capture() as captured:
        out.print(what)
    click.echo("\n".join(line.rstrip() for line in captured.get().splitlines()))


def table(
    columns: Sequence[str], rows: Iterable[Sequence[str | Text]], *, text_columns: int = 1
) -> Table:
    """Make a table: the first columns are text, the others numbers, aligned right."""
    made = Table(box=SIMPLE_HEAD, pad_edge=False)
    for number, column in enumerate(columns):
        side: JustifyMethod = "left" if number < text_columns else "right"
        made.add_column(Text(column), justify=side)
    for row in rows:
        made.add_row(*(cell if isinstance(cell, Text) else Text(cell) for cell in row))
    return made


def mark(good: bool) -> Text:
    """Return a verdict."""
    return Text("✓", "green") if good else Text("✗", "bold red")
