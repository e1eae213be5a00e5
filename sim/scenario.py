"""What the operator does, from the events of a scenario."""

from collections.abc import Iterable
from typing import NamedTuple

from heatwright.spec import Event

PRESS_S = 0.1
"""A brisk press: this long down, then at least as long up."""


class Action(NamedTuple):
    """The operator's hand from a time on."""

    time_s: float
    key: str | None
    """The key that is held, None for none."""


def actions(scenario: Iterable[Event]) -> tuple[Action, ...]:
    """Return the key presses of a scenario, in order.

    Each press is 100 ms down and 100 ms up; an event whose time comes while the one before is
    still being done waits for its end.
    """
    found: list[Action] = []
    free_s = 0.0
    for event in sorted((e for e in scenario if e.press is not None), key=_begin_s):
        start_s = max(_begin_s(event), free_s)
        for number in range(event.times):
            down_s = start_s + number * 2 * PRESS_S
            found += [Action(down_s, event.press), Action(down_s + PRESS_S, None)]
        free_s = start_s + event.times * 2 * PRESS_S
    return tuple(found)


def end_s(scenario: Iterable[Event]) -> float:
    """Return the time at which a scenario ends: its `for`.

    Raises:
        ValueError: it has none.

    """
    for event in scenario:
        if event.for_s is not None:
            return event.for_s
    message = "A scenario needs its end: - {for: 30 min}"
    raise ValueError(message)


def _begin_s(event: Event) -> float:
    return event.at_s or 0.0
