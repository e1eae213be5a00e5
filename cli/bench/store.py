"""The data for all tabs: written by the board's thread, read by the server's."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from threading import Lock
from typing import TYPE_CHECKING, Any

from heatwright.cli.bench.parts.seat import Line

if TYPE_CHECKING:
    from PIL.Image import Image

MOST_POINTS = 20_000
"""Limit of a chart's points: beyond it every second point of the older half is removed."""
MOST_LINES = 1_000
"""Maximum number of lines of a console."""

Point = tuple[float | None, ...]


@dataclass
class Chart:
    """The chart of a loop; epoch -- how often its points were thinned out."""

    points: list[Point] = field(default_factory=list)
    epoch: int = 0

    def add(self, points: list[Point]) -> None:
        """Add points; if there are too many, the older ones are thinned out."""
        self.points += points
        if len(self.points) > MOST_POINTS:
            half = len(self.points) // 2
            self.points = self.points[:half:2] + self.points[half:]
            self.epoch += 1


@dataclass
class Roll:
    """The last lines of a console; first -- the number of the oldest line kept."""

    lines: list[Any] = field(default_factory=list)
    first: int = 0

    def add(self, lines: list[Any]) -> None:
        """Add lines; if there are too many, the oldest are removed."""
        self.lines += lines
        if (beyond := len(self.lines) - MOST_LINES) > 0:
            del self.lines[:beyond]
            self.first += beyond

    def since(self, number: int) -> tuple[list[Any], int]:
        """Return the lines from a number on, and the number of the next one."""
        return self.lines[max(0, number - self.first) :], self.first + len(self.lines)


@dataclass
class Told:
    """The data that one tab has already received."""

    state: dict[str, Any] = field(default_factory=dict)
    charts: dict[str, tuple[int, int]] = field(default_factory=dict)
    rolls: dict[str, int] = field(default_factory=dict)
    wants_variables: bool = False
    variables: Mapping[str, Any] | None = None


class Store:
    """The latest state, with charts and consoles; about -- the constant data.

    pictures -- of touch displays, by the interface's number; drawn -- how often each was drawn;
    watchers -- called in the board's thread when there is news.
    """

    def __init__(self, about: Mapping[str, Any]) -> None:
        self.about = dict(about)
        self.pictures: dict[int, Image] = {}
        self.drawn: dict[int, int] = {}
        self.watchers: set[Callable[[], None]] = set()
        self._lock = Lock()
        self._state: dict[str, Any] = {}
        self._variables: dict[str, Any] = {}
        self._charts: dict[str, Chart] = {}
        self._rolls: dict[str, Roll] = {}

    def draw(self, number: int, picture: Image) -> None:
        """Store the picture of a touch display."""
        self.pictures[number] = picture
        self.drawn[number] = self.drawn.get(number, 0) + 1

    def publish(
        self,
        state: Mapping[str, Any],
        points: Mapping[str, list[Point]],
        lines: Mapping[str, list[Any]],
        variables: Mapping[str, Any] | None,
    ) -> None:
        """Store new data: points by loop, lines by console."""
        with self._lock:
            self._state = dict(state)
            for loop, added in points.items():
                self._charts.setdefault(loop, Chart()).add(added)
            for roll, found in lines.items():
                self._rolls.setdefault(roll, Roll()).add(found)
            if variables is not None:
                self._variables = dict(variables)
        for watcher in tuple(self.watchers):
            watcher()

    def news(self, told: Told) -> dict[str, Any]:
        """Return the data that a tab has not received yet, and mark it as received."""
        with self._lock:
            found: dict[str, Any] = {}
            changed = {
                key: value
                for key, value in self._state.items()
                if key not in told.state or told.state[key] != value
            }
            if changed:
                found["state"] = changed
                told.state = self._state
            if charts := dict(self._new_points(told)):
                found["charts"] = charts
            if rolls := dict(self._new_lines(told)):
                found["lines"] = rolls
            if told.wants_variables and told.variables is not self._variables:
                found["variables"] = told.variables = self._variables
            return found

    def _new_points(self, told: Told) -> Any:
        for loop, chart in self._charts.items():
            epoch, count = told.charts.get(loop, (-1, 0))
            fresh = epoch != chart.epoch
            points = chart.points if fresh else chart.points[count:]
            told.charts[loop] = chart.epoch, len(chart.points)
            if points:
                yield loop, {"fresh": fresh, "points": points}

    def _new_lines(self, told: Told) -> Any:
        for name, roll in self._rolls.items():
            lines, told.rolls[name] = roll.since(told.rolls.get(name, 0))
            if lines:
                yield name, lines


def as_told(line: Line) -> list[Any]:
    """Return a console's line as a list for JSON."""
    return [round(line.time_s, 3), line.sent, line.text, line.by_itself]
