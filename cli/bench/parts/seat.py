"""The base class of the seats: a seat is the person or program that uses one interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from heatwright.cli.bench.world import LiveWorld
from heatwright.spec import Controller

if TYPE_CHECKING:
    from PIL.Image import Image

Order = Mapping[str, Any]
"""A command as the page sent it; each value is checked before it is used."""


class BadOrder(ValueError):
    """The command cannot be executed; the text says why."""


class Line(NamedTuple):
    """A line of a console: when it ended (s), whether the board sent it, and its text.

    by_itself -- whether it belongs to the requests that a host repeats by itself.
    """

    time_s: float
    sent: bool
    text: str
    by_itself: bool = False


class Live(Protocol):
    """The part of `Board` that a command needs."""

    world: LiveWorld

    @property
    def is_quick(self) -> bool:
        """Whether the board is faster than real time, or paused: a key then acts on release."""

    def later(self, in_s: float, act: Callable[[], None]) -> None:
        """Schedule an action in `in_s` seconds of board time."""

    def record(self, event: Mapping[str, Any]) -> None:
        """Record an event of a scenario."""

    def remark(self, text: str) -> None:
        """Record an action that a scenario cannot express."""


class Seat:
    """The user of one interface; it looks up the simulated interface again after a power cut."""

    kind: str

    def __init__(self, controller: Controller, number: int) -> None:
        self.controller, self.number = controller, number

    def part(self, world: LiveWorld) -> Any:
        """Return the simulated interface."""
        return world.device.interfaces[self.number]

    def about(self) -> dict[str, Any]:
        """Return the data that the page needs once."""
        return {}

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return what the interface shows now; all pin changes up to now have been processed."""
        del world
        return {}

    def lines(self, world: LiveWorld) -> list[Line]:
        """Return the lines since the last call, and drop them from the simulated interface."""
        del world
        return []

    def picture(self, world: LiveWorld) -> Image | None:
        """Draw what the interface shows, if it has changed since the last call."""
        del world
        return None

    def act(self, live: Live, order: Order) -> None:
        """Execute a command of the page. Raises BadOrder: the command cannot be executed."""
        del live, order
        raise BadOrder(f"The interface {self.kind} accepts no commands.")


def text_of(order: Order, key: str, longest: int = 500) -> str:
    """Return a text of a command: printable ASCII, of at most `longest` characters."""
    value = order.get(key)
    if not isinstance(value, str) or not value.isprintable() or not value.isascii():
        raise BadOrder(f"{key}: only printable ASCII characters are allowed.")
    if not value.strip() or len(value) > longest:
        raise BadOrder(f"{key}: 1 to {longest} characters are needed.")
    return value


def number_of(order: Order, key: str, least: float, most: float) -> float:
    """Return a number of a command, from `least` to `most`."""
    value = order.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadOrder(f"{key}: a number is needed.")
    if not least <= value <= most:  # also true for NaN
        raise BadOrder(f"{key}: {value:g} is not from {least:g} to {most:g}.")
    return float(value)


def flag_of(order: Order, key: str) -> bool:
    """Return a boolean of a command."""
    value = order.get(key)
    if not isinstance(value, bool):
        raise BadOrder(f"{key}: true or false is needed.")
    return value
