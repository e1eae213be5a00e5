"""What is the same for whoever sits at an interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from heatwright.cli.bench.world import LiveWorld
from heatwright.spec import Controller

if TYPE_CHECKING:
    from PIL.Image import Image

Order = Mapping[str, Any]
"""What the page asks for, as it came; each value is looked at before it is used."""


class BadOrder(ValueError):
    """What the page asks for cannot be done; says why."""


class Line(NamedTuple):
    """A line of a console: when it ended (s), whether the board sent it, and its text.

    by_itself -- whether it belongs to what a host asks by itself, over and over.
    """

    time_s: float
    sent: bool
    text: str
    by_itself: bool = False


class Live(Protocol):
    """The running board, as an order finds it."""

    world: LiveWorld

    @property
    def is_quick(self) -> bool:
        """Whether it runs faster than the clock on the wall, or stands: a hand is too slow."""

    def later(self, in_s: float, act: Callable[[], None]) -> None:
        """Do something in so long, s of the board."""

    def record(self, event: Mapping[str, Any]) -> None:
        """Note an event of a scenario that has been done now."""

    def remark(self, text: str) -> None:
        """Note what no scenario can say."""


class Seat:
    """Somebody at one interface, who finds its simulation anew after each loss of power."""

    kind: str

    def __init__(self, controller: Controller, number: int) -> None:
        self.controller, self.number = controller, number

    def part(self, world: LiveWorld) -> Any:
        """Return the simulated interface."""
        return world.device.interfaces[self.number]

    def about(self) -> dict[str, Any]:
        """Return what the page has to know once."""
        return {}

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return what it shows now. What the pins have done is fed up to now."""
        del world
        return {}

    def lines(self, world: LiveWorld) -> list[Line]:
        """Return what went over the line since the last call, and have the part forget it."""
        del world
        return []

    def picture(self, world: LiveWorld) -> Image | None:
        """Draw what it shows, if that is another than at the last call."""
        del world
        return None

    def act(self, live: Live, order: Order) -> None:
        """Do what the page asks for. Raises BadOrder."""
        del live, order
        raise BadOrder(f"Nobody can do anything at {self.kind}.")


def text_of(order: Order, key: str, longest: int = 500) -> str:
    """Return a text of an order: plain characters, and not too many of them."""
    value = order.get(key)
    if not isinstance(value, str) or not value.isprintable() or not value.isascii():
        raise BadOrder(f"{key}: plain characters are needed.")
    if not value.strip() or len(value) > longest:
        raise BadOrder(f"{key}: 1 to {longest} characters are needed.")
    return value


def number_of(order: Order, key: str, least: float, most: float) -> float:
    """Return a number of an order, within its ends."""
    value = order.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadOrder(f"{key}: a number is needed.")
    if not least <= value <= most:  # NaN is not, either
        raise BadOrder(f"{key}: {value:g} is not from {least:g} to {most:g}.")
    return float(value)


def flag_of(order: Order, key: str) -> bool:
    """Return a yes or no of an order."""
    value = order.get(key)
    if not isinstance(value, bool):
        raise BadOrder(f"{key}: true or false is needed.")
    return value
