"""Draws the wiring of a board: its pins on the left, the devices connected to them on the right."""

import re
import sys
from collections.abc import Iterable, Sequence
from functools import partial
from itertools import groupby
from textwrap import wrap
from typing import Any, NamedTuple

from heatwright.generator.plan.parts import Symbol, Wiring

# schemdraw would import matplotlib, which takes a second and is not needed for SVG.
sys.modules.setdefault("schemdraw.backends.mpl", None)  # type: ignore[arg-type]

_CHARACTER = 0.17
"""Width of a character, in units of the drawing (half an inch)."""
_SMALL, _NORMAL = 9, 10
_ROW, _SHUNT, _TO_SHUNT = 0.9, 1.5, 0.6
_NOTE_CHARACTERS = 40
NOTES = (
    "A switch's other side goes to the return of its load's supply.",
    "Joined: ground of board, sensors, switches' inputs and lines.",
)
_DECIMALS = re.compile(r"\d+\.\d{3,}")


class Wires:
    """A drawing that is made only when it is rendered, so that planning a firmware stays quick."""

    def __init__(self, name: str, board: str, rows: Iterable[Wiring]) -> None:
        """Store the connections of the controller `name` on its board; `__str__` draws them."""
        self._name, self._board, self._rows = name, board, tuple(rows)

    def __str__(self) -> str:
        """Return the SVG; the same rows give the same bytes."""
        return drawn(self._name, self._board, self._rows)


class _Placed(NamedTuple):
    """A row and its vertical position on the drawing."""

    row: Wiring
    y: float
    device: str
    notes: tuple[str, ...] = ()
    """Lines of text below a device, at its last row."""


def drawn(name: str, board: str, rows: Sequence[Wiring], notes: Sequence[str] = NOTES) -> str:
    """Draw the rows from the top down, and notes below them."""
    import schemdraw  # noqa: PLC0415 - not every planned firmware is drawn
    from schemdraw import elements  # noqa: PLC0415

    schemdraw.use("svg")
    schemdraw.svgconfig.text = "text"
    drawing = schemdraw.Drawing(show=False)
    drawing.config(
        unit=1.1, inches_per_unit=0.5, fontsize=_NORMAL, font="sans-serif", lw=1.2, bgcolor="white"
    )
    pen = _Pen(drawing, elements)
    placed, bottom = _placed(rows)
    wires = [(each, pen.wire(each)) for each in placed]
    edge = max((end for each, end in wires if each.row.ends), default=0.0)
    for device, group in groupby(wires, key=lambda wire: wire[0].device):
        ending = [(each, end) for each, end in group if each.row.ends]
        for each, end in ending:
            pen.line(end, edge, each.y)
        if ending:
            pen.device(device, [each for each, _ in ending], edge)
    pen.board((name, board), placed, bottom)
    for number, line in enumerate(notes):
        pen.text(line, 0.4, bottom - 0.2 - 0.4 * number, _SMALL)
    pen.widen(bottom)
    text = drawing.get_imagedata("svg").decode("utf-8")
    text = _DECIMALS.sub(lambda found: f"{float(found[0]):.2f}", text)
    return text.replace("><", ">\n<") + "\n"  # one element per line, for readable diffs


def _placed(rows: Sequence[Wiring]) -> tuple[list[_Placed], float]:
    """Give each row its position; also return the lowest one."""
    y, found = 0.0, []
    for device, group in groupby(rows, key=lambda row: row.what.partition(", ")[0]):
        wires = list(group)
        y -= 0.5
        for row in wires:
            if row.pin == "–":
                continue
            ways = {symbol.way for symbol in row.symbols}
            y -= _ROW + _SHUNT * ("up" in ways)
            found.append(_Placed(row, y, device.replace("`", "")))
            y -= _SHUNT * ("down" in ways)
        notes = _notes(wires)
        found[-1] = found[-1]._replace(notes=notes)
        y -= 0.4 * len(notes)
    return found, y - _ROW


def _notes(rows: Sequence[Wiring]) -> tuple[str, ...]:
    """Return the lines below a device: the needs of its row without a pin, or else of its pins."""
    hows = [row.how for row in rows if row.pin == "–"]
    hows = hows or [row.how for row in rows if row.ends and row.how != "the same"]
    return tuple(line for how in dict.fromkeys(hows) for line in wrap(how, _NOTE_CHARACTERS))


def _terminal(row: Wiring) -> str:
    return row.end or row.what.partition(", ")[2] or row.how.partition(";")[0]


class _Pen:
    """Draws rows with the library's symbols."""

    def __init__(self, drawing: Any, elements: Any) -> None:
        self._drawing, self._of = drawing, elements
        self._right = 0.0
        self._shapes = {
            "resistor": elements.ResistorIEC,
            "sensor": elements.Thermistor,
            "contact": elements.Switch,
            "closed": partial(elements.Switch, nc=True),
            "led": elements.LED,
            "fuse": elements.FuseIEC,
        }

    def wire(self, placed: _Placed) -> float:
        """Draw the symbols of a row; return the position of the wire's end."""
        x, y = 0.0, placed.y
        for number, symbol in enumerate(placed.row.symbols, 1):
            if symbol.way == "along":
                x = self._along(symbol, x, y)
                continue
            end = self._shunt(symbol, x, y)
            goes_on = placed.row.ends or number < len(placed.row.symbols)
            self.line(x, end if goes_on else x + _TO_SHUNT, y)
            x = end
        if placed.row.ends:
            self.line(x, x + _TO_SHUNT, y)
            x += _TO_SHUNT
        return x

    def line(self, start: float, end: float, y: float) -> None:
        """Draw a wire."""
        if end > start:
            self._drawing += self._of.Line().at((start, y)).to((end, y))

    def text(self, text: str, x: float, y: float, size: int = _NORMAL, align: str = "left") -> None:
        """Write a line of text, centred vertically at y."""
        at = (x - 0.1 * (align == "center"), y - 0.1)  # offset of the library's labels
        if align == "left":
            self._right = max(self._right, x + len(text) * _CHARACTER * size / _NORMAL)
        self._drawing += (
            self._of.Label().at(at).label(text, fontsize=size, halign=align, valign="center")
        )

    def widen(self, y: float) -> None:
        """Extend the drawing to the end of each text: the library ignores the width of texts."""
        self._drawing += self._of.Gap().at((self._right, y)).to((self._right + 0.1, y))

    def _along(self, symbol: Symbol, x: float, y: float) -> float:
        self.line(x, x + 0.5, y)
        x += 0.5
        width = max(1.2, len(symbol.text) * _CHARACTER + 0.3)
        if symbol.shape == "rail":
            self._drawing += self._of.Dot(open=True).at((x, y))
            self.text(symbol.text, x + 0.25, y)
        elif symbol.shape == "box":
            self._box(x, y - 0.35, x + width, y + 0.35)
            self.text(symbol.text, x + width / 2, y, align="center")
        else:
            self._drawing += self._shapes[symbol.shape]().at((x, y)).to((x + width, y))
            self.text(symbol.text, x + width / 2, y + 0.7, _SMALL, "center")
        return x + width

    def _shunt(self, symbol: Symbol, x: float, y: float) -> float:
        """Draw a symbol that leads to a rail."""
        x += _TO_SHUNT
        up = symbol.way == "up"
        end = y + 1.1 if up else y - 1.1
        start, stop = ((x, end), (x, y)) if up else ((x, y), (x, end))
        self._drawing += self._of.Dot(radius=0.06).at((x, y))
        self._drawing += self._shapes[symbol.shape]().at(start).to(stop)
        self.text(symbol.text, x + (0.8 if symbol.shape == "led" else 0.4), (y + end) / 2, _SMALL)
        rail = self._of.Vdd().label(symbol.rail, fontsize=_SMALL) if up else self._of.Ground()
        self._drawing += rail.at((x, end))
        return x + 0.6 + len(symbol.text) * _CHARACTER * 0.9

    def _box(self, left: float, bottom: float, right: float, top: float) -> None:
        self._drawing += self._of.Rect(corner1=(left, bottom), corner2=(right, top)).at((0, 0))

    def device(self, name: str, rows: Sequence[_Placed], left: float) -> None:
        """Draw a device: its terminals, its name, its further needs."""
        ends = [_terminal(each.row) for each in rows]
        notes = rows[-1].notes
        column = max(map(len, ends)) * _CHARACTER + 0.5
        inside = max(column + len(name) * _CHARACTER, *(len(each) * 0.15 for each in notes), 0.0)
        bottom = rows[-1].y - 0.45 - 0.4 * len(notes)
        self._box(left, bottom, left + inside + 0.5, rows[0].y + 0.45)
        for end, each in zip(ends, rows, strict=True):
            self.text(end, left + 0.2, each.y)
        self.text(name, left + column, rows[0].y)
        for number, line in enumerate(reversed(notes)):
            self.text(line, left + 0.2, bottom + 0.3 + 0.4 * number, _SMALL)

    def board(self, title: Sequence[str], rows: Sequence[_Placed], bottom: float) -> None:
        """Draw the board with the pins in use."""
        pins = {each.y: each.row.pin for each in rows}
        width = max(map(len, [*title, *pins.values()])) * _CHARACTER + 0.5
        self._box(-width, bottom, 0.0, 1.2)
        for number, line in enumerate(title):
            self.text(line, -width / 2, 0.8 - 0.45 * number, align="center")
        for y, pin in pins.items():
            self.text(pin, -0.2, y, align="right")
