"""Tables on standard output."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import click
from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderableType, RenderResult
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from heatwright.sim.judges.metrics import Metrics

WIDE = 200
"""Width in characters without a terminal: a file can be scrolled."""
WIDE_GAP, NARROW_GAP = 3, 1
"""Blanks between two columns; the second number if there is little room."""


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
) -> RenderableType:
    """Make a table: the first columns are text, the others numbers, aligned right.

    On a narrow terminal heads and texts are wrapped; if that is not enough, the last columns go
    into further tables. No word and no number is cut.
    """
    texts = [[cell if isinstance(cell, Text) else Text(cell) for cell in row] for row in rows]
    return _Sheet([_Column(*each) for each in zip(columns, *texts, strict=True)], text_columns)


def show_figures(figures: Mapping[str, Metrics]) -> None:
    """Print the figures of merit of each loop, and its loads."""
    from heatwright.cli.figures import COLUMNS, LOAD_COLUMNS, LOAD_TEXTS, cells, load_cells  # noqa: PLC0415

    show(table(("loop", *COLUMNS), [(loop, *cells(each)) for loop, each in figures.items()]))
    if loads := load_cells(figures):
        show(table(LOAD_COLUMNS, loads, text_columns=LOAD_TEXTS))


class _Column:
    def __init__(self, head: str, *cells: Text) -> None:
        self.head = Text(head)
        self.cells = cells

    @property
    def whole(self) -> int:
        """Width without any wrapped line."""
        return max(cell_len(text.plain) for text in (self.head, *self.cells))

    def least(self, is_text: bool) -> int:
        """Width below which a word, or a number, would be cut."""
        lines = [*self.head.plain.split()]
        for cell in self.cells:
            lines += cell.plain.split() if is_text else [cell.plain]
        return max(map(cell_len, lines), default=0)


class _Sheet:
    """One table, or several that repeat the columns of text."""

    def __init__(self, columns: Sequence[_Column], text_columns: int) -> None:
        self._columns = columns
        self._texts = text_columns

    def __rich_console__(self, _: Console, options: ConsoleOptions) -> RenderResult:
        room = options.max_width
        whole = [column.whole for column in self._columns]
        if _taken(whole, WIDE_GAP) <= room:
            yield self._table(range(len(whole)), WIDE_GAP)
            return
        least = [column.least(place < self._texts) for place, column in enumerate(self._columns)]
        gap = WIDE_GAP if _taken(least, WIDE_GAP) <= room else NARROW_GAP
        texts, shown = [*range(self._texts)], [*range(self._texts)]
        for place in range(self._texts, len(least)):
            wider = [*shown, place]
            if len(shown) > len(texts) and _taken([least[each] for each in wider], gap) > room:
                yield self._table(shown, gap, least)
                wider = [*texts, place]
            shown = wider
        yield self._table(shown, gap, least)

    def _table(
        self, places: Iterable[int], gap: int, widths: Sequence[int | None] | None = None
    ) -> Table:
        shown = [*places]
        pad = (gap - 1) // 2
        made = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, pad))
        for place in shown:
            is_text = place < self._texts
            side: JustifyMethod = "left" if is_text else "right"
            width = None if is_text or widths is None else widths[place]
            made.add_column(self._columns[place].head, justify=side, width=width)
        for row in zip(*(self._columns[place].cells for place in shown), strict=True):
            made.add_row(*row)
        return made


def _taken(widths: Sequence[int], gap: int) -> int:
    return sum(widths) + gap * (len(widths) - 1) + 2  # a blank on either side


def mark(good: bool) -> Text:
    """Return the sign of a verdict."""
    return Text("✓", "green") if good else Text("✗", "bold red")
