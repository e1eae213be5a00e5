"""What the lines of a board tell of a loop, by the interface that sends them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from heatwright.cli.ends import Refused
from heatwright.cli.identify.asked import PLOTTER_FULL, plotter_of
from heatwright.sim.identify.cells import DIALECTS, fields, value
from heatwright.spec import Controller, Gcode, SerialLog, SerialPlotter
from heatwright.spec.interfaces import Line

HOST_FULL = 127.0
"""The duty of a host's reports is in 127ths."""
HOST_EVERY_S = 1.0
LOG_LEAST_S = 10.0
"""How often a log is asked for at most: an answer of 600 entries takes 6 s."""
LOG_WIDTH = 4
_BLANKS = next(each for each in DIALECTS if each.delimiter is None)
_COMMAS = DIALECTS[0]


class Reading(NamedTuple):
    """A loop at one time; None: not told."""

    time_s: float
    temperature_c: float | None
    setpoint_c: float | None
    duty_percent: float | None


Read = Callable[[str, float], Iterator[Reading]]
"""Reads a line that has come at a time, s since the port was opened."""


@dataclass(frozen=True)
class Hearing:
    """How to listen to a loop: its line, what is sent and how often, and how answers are read."""

    loop: str
    kind: str
    line: Line
    read: Read
    asks: bytes = b""
    """Empty: the board speaks by itself."""
    every_s: float = 0.0


def hearing_of(file_name: str, controller: Controller, loop: str | None) -> Hearing:
    """Choose the first interface that tells the course of a loop; of any, if none is named.

    Raises Refused where none does.
    """
    if loop is not None and loop not in controller.loops:
        able = ", ".join(controller.loops)
        raise Refused(f"{file_name}: has no loop {loop}; there are {able}.")
    found = (each for each in _all(controller) if loop in {None, each.loop})
    first = next(found, None)
    if first is None:
        whose = "" if loop is None else f" of {loop}"
        raise Refused(
            f"{file_name}: no line tells the course{whose}; add an interface, such as "
            "{kind: serial_plotter, loop: NAME, baud: 9600}."
        )
    return first


def _all(controller: Controller) -> Iterator[Hearing]:
    for each in controller.interfaces:
        if isinstance(each, SerialPlotter):
            read = _plotted(controller, each.loop)
            yield Hearing(each.loop, each.kind, each.line, read)
        elif isinstance(each, Gcode):
            for address, loop in each.loops.items():
                read = _reported(address, [*each.loops])
                yield Hearing(loop, each.kind, each.line, read, b"M105\n", HOST_EVERY_S)
        elif isinstance(each, SerialLog):
            every_s = max(LOG_LEAST_S, each.every_s)
            yield Hearing(each.loop, each.kind, each.line, _Logged(), b"log\n", every_s)


def _plotted(controller: Controller, loop: str) -> Read:
    found = plotter_of(controller, loop)
    assert found is not None  # noqa: S101 - the interface is there
    duty, width = found

    def read(line: str, time_s: float) -> Iterator[Reading]:
        cells = [value(text, _BLANKS) for text in fields(line, _BLANKS)]
        numbers = [each for each in cells if each is not None]
        if line.startswith("$") and len(numbers) == len(cells) == width:
            percent = 100 * numbers[duty] / PLOTTER_FULL
            yield Reading(time_s, numbers[0], numbers[1], percent)

    return read


def _reported(address: str, served: list[str]) -> Read:
    """Read a printer's report: `ok T:201.3 /200.0 B:60.1 /60.0 @:76 B@:31`."""
    several = sum(each.startswith("T") for each in served) > 1
    title, duty = address, f"{address}@"
    if address.startswith("T"):
        title, duty = (address, f"@{address[1:]}") if several else ("T", "@")
    found_c = re.compile(rf"(?:^|\s){title}:(-?[\d.]+) ?/(-?[\d.]+)")
    found_duty = re.compile(rf"(?:^|\s){duty}:(\d+)")

    def read(line: str, time_s: float) -> Iterator[Reading]:
        temperatures, share = found_c.search(line), found_duty.search(line)
        if temperatures is not None and share is not None:
            percent = 100 * int(share[1]) / HOST_FULL
            yield Reading(time_s, float(temperatures[1]), float(temperatures[2]), percent)

    return read


@dataclass
class _Logged:
    """Reads the answers to `log`: each has all entries, and only the new ones are told.

    The log has its own clock, which begins anew with the board: then its entries go on behind
    those that are known.
    """

    newest_s: float = -1.0
    before_s: float = 0.0
    answer: list[Reading] = field(default_factory=list)

    def __call__(self, line: str, time_s: float) -> Iterator[Reading]:
        del time_s
        if line.startswith("time_s,"):
            self.answer.clear()
        elif not line:
            yield from self._new()
        else:
            cells = [value(text, _COMMAS) for text in fields(line, _COMMAS)]
            at_s, *told = cells[:LOG_WIDTH]
            if len(cells) >= LOG_WIDTH and at_s is not None:
                self.answer.append(Reading(at_s, *(known(each) for each in told)))

    def _new(self) -> Iterator[Reading]:
        if not self.answer:
            return
        if self.answer[-1].time_s < self.newest_s:
            self.before_s += self.newest_s
            self.newest_s = -1.0
        for each in self.answer:
            if each.time_s > self.newest_s:
                self.newest_s = each.time_s
                yield each._replace(time_s=self.before_s + each.time_s)
        self.answer.clear()


def known(number: float | None) -> float | None:
    """Return a number; None for a gap."""
    return None if number is None or math.isnan(number) else number
