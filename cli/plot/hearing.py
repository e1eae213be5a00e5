"""Ways to read a loop's temperatures from a board's serial line, by its interface."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

from heatwright.cli.ends import Refused
from heatwright.spec import Controller
from heatwright.spec.interfaces import Line
from heatwright.spec.registry import Layer, place_of

LAYER = Layer("hearing", "heatwright.cli.plot", "way to read its lines", ("hearings",))
"""The layer is optional: a kind of interface need not have it."""


class Reading(NamedTuple):
    """Reading, setpoint and duty of a loop at one time; None: not known."""

    time_s: float
    temperature_c: float | None
    setpoint_c: float | None
    duty_percent: float | None


Read = Callable[[str, float], Iterator[Reading]]
"""Reads a message; the second argument is its time, in s since the port was opened."""
Cut = Callable[[bytes], tuple[list[str], bytes]]
"""Cuts received bytes into messages, as text, and the rest, which is not complete yet."""
LONGEST_LINE = 1024


def lines(come: bytes) -> tuple[list[str], bytes]:
    """Cut at the ends of lines; a line that is too long loses its beginning."""
    *ended, rest = come.split(b"\n")
    texts = [line[-LONGEST_LINE:].decode("ascii", errors="replace").strip() for line in ended]
    return texts, rest[-LONGEST_LINE:]


@dataclass(frozen=True)
class Hearing:
    """How to listen to a loop: its line, what is sent and how often, and how answers are read."""

    loop: str
    kind: str
    line: Line
    read: Read
    asks: bytes = b""
    """The request to send; empty: the board sends by itself."""
    every_s: float = 0.0
    cut: Cut = lines


def hearing_of(file_name: str, controller: Controller, loop: str | None) -> Hearing:
    """Choose the first interface that sends the readings of a loop, or of any loop if it is None.

    Raises Refused: there is no such interface.
    """
    if loop is not None and loop not in controller.loops:
        able = ", ".join(controller.loops)
        raise Refused(f"{file_name}: has no loop {loop}; there are {able}.")
    found = (each for each in _all(controller) if loop in {None, each.loop})
    first = next(found, None)
    if first is None:
        whose = "" if loop is None else f" of {loop}"
        raise Refused(
            f"{file_name}: no interface sends the readings{whose}; add one, such as "
            "{kind: serial_plotter, loop: NAME, baud: 9600}."
        )
    return first


def _all(controller: Controller) -> Iterator[Hearing]:
    """Yield the hearings of each interface whose kind has a module in this package."""
    for each in controller.interfaces:
        name = place_of("interface", LAYER, each.kind)
        if find_spec(name) is not None:
            yield from import_module(name).hearings(controller, each)


def known(number: float | None) -> float | None:
    """Return the number, or None for a gap, NaN or infinity, which JSON cannot hold."""
    return number if number is not None and math.isfinite(number) else None
