"""How soon the display shows a key's change, and when it is set up again."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.interfaces.lcd import Screen
from heatwright.sim.interfaces.lcd_keypad import LCD_PINS
from heatwright.sim.native.pins import pin_number
from heatwright.sim.timing.figures import BUTTON_MS, Figure
from heatwright.sim.timing.operator import SETTLED_S, Press
from heatwright.spec import Board

NUMBER = re.compile(r"-?\d+(\.\d+)?")
SETPOINT_ROW = 1
ALLOWED_K = 1e-3
"""Tolerance of a setpoint that the keypad has set: the firmware adds in single precision."""
FIRST_TWO_MORE = 3
"""Start-ups that define a period; the first one, at power-on, is slower than the others."""
WRITES_OF_A_BYTE = 2
"""Falls of E for an address or a character; more than this between characters is a start-up."""


def button_to_display(pressed: Sequence[Press], history: Sequence[Screen]) -> Figure:
    """Return the time from the keys' voltage to the complete new setpoint in the text, ms."""
    times_s = np.array([screen.time_s for screen in history])
    rows = [screen.rows[SETPOINT_ROW] for screen in history]
    answers = [_answer_s(press, times_s, rows) for press in pressed]
    shown = [1e3 * answer_s for answer_s in answers if answer_s is not None]
    everything = bool(shown) and len(shown) == len(pressed)
    details = {"median": float(np.median(shown))} if shown else {}
    return Figure(
        "key to complete setpoint on the display",
        "ms",
        max(shown) if everything else None,
        BUTTON_MS,
        details={**details, "presses": len(pressed), "not_shown": len(pressed) - len(shown)},
    )


def _answer_s(press: Press, times_s: NDArray[np.float64], rows: Sequence[str]) -> float | None:
    """Return the time from a press to the final text, s; None if that does not show the setpoint.

    A display of whole degrees may not change for a smaller step: it is then right at once.
    """
    first, end = np.searchsorted(times_s, (press.time_s, press.time_s + SETTLED_S))
    settled = rows[end - 1]
    shown = NUMBER.search(settled)
    if shown is None:
        return None
    half_k = 0.5 * 10.0 ** -max(len(shown[1] or "") - 1, 0)
    if abs(float(shown.group()) - press.setpoint_c) > half_k + ALLOWED_K:
        return None
    if first and rows[first - 1] == settled:
        return 0.0
    place = next((place for place in range(first, end) if rows[place] == settled), None)
    return None if place is None else float(times_s[place]) - press.time_s


class StartUps:
    """Records when the display is set up, s: many instructions, and no character between them."""

    def __init__(self, board: Board) -> None:
        rs, enable = (pin_number(board.pins[name].port_name) for name in LCD_PINS[:2])
        self._rs, self._enable, self._clock_hz = rs, enable, board.clock_hz
        self._parts: list[NDArray[Any]] = []

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes."""
        del sent
        self._parts.append(pins[np.isin(pins["pin"], (self._rs, self._enable))])

    def times_s(self) -> list[float]:
        """Return the time of the first instruction of each start-up, s."""
        events = np.concatenate(self._parts)
        turns = np.cumsum(events["pin"] == self._rs)
        falls = (events["pin"] == self._enable) & (events["state"] & 1 == 0)
        _, first, count = np.unique(turns[falls], return_index=True, return_counts=True)
        cycles = events["cycle"][falls][first[count > WRITES_OF_A_BYTE]]
        return [float(cycle) / self._clock_hz for cycle in cycles]


def to_come(times_s: Sequence[float], until_s: float) -> list[float]:
    """Extrapolate times to an end, s, by the last interval; with fewer than three, return them."""
    if len(times_s) < FIRST_TWO_MORE:
        return list(times_s)
    every_s = times_s[-1] - times_s[-2]
    return [*times_s[:-1], *np.arange(times_s[-1], until_s, every_s).tolist()]
