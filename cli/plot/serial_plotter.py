"""Readings of a loop from the lines of its plotter, which the board sends by itself."""

import math
from collections.abc import Iterator

from heatwright.cli.identify.asked import PLOTTER_FULL, plotter_of
from heatwright.cli.plot.hearing import Hearing, Read, Reading
from heatwright.sim.identify.cells import DIALECTS, fields, value
from heatwright.spec import Controller, SerialPlotter

_BLANKS = next(each for each in DIALECTS if each.delimiter is None)


def hearings(controller: Controller, interface: SerialPlotter) -> Iterator[Hearing]:
    """Yield the way to read the plotter's loop."""
    read = _plotted(controller, interface.loop)
    yield Hearing(interface.loop, interface.kind, interface.line, read)


def _plotted(controller: Controller, loop: str) -> Read:
    found = plotter_of(controller, loop)
    assert found is not None  # noqa: S101 - the loop has a plotter
    duty, width = found

    def read(line: str, time_s: float) -> Iterator[Reading]:
        cells = [value(text, _BLANKS) for text in fields(line, _BLANKS)]
        numbers = [each for each in cells if each is not None and math.isfinite(each)]
        if line.startswith("$") and len(numbers) == len(cells) == width:
            percent = 100 * numbers[duty] / PLOTTER_FULL
            yield Reading(time_s, numbers[0], numbers[1], percent)

    return read
