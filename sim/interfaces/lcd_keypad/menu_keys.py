"""Which keys of the LCD keypad shield do what in the menu of a loop with programs.

Every way begins at the first screen and leads back to it: RIGHT from there comes the screen of the
times, then that of the program; to the left of it are the single values. A screen that is left
begins anew.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from heatwright.sim.interfaces.lcd_keypad.keypad import Keypad
from heatwright.sim.scenario import PRESS_S
from heatwright.spec import ProgramOrder

_TO_PROGRAM, _FROM_PROGRAM = ("right", "right"), ("left", "left")
_CHOICES = {"pause": 0, "resume": 0, "skip": 1, "stop": 2, "jump": 3}
"""How often UP is pressed for what can be asked of a program that runs; `jump 1` is the first of
its segments."""
_AT_ONCE = ("pause", "resume")
"""All else asks whether it is meant."""


def keys_for(order: ProgramOrder) -> tuple[str, ...]:
    """List the presses that give an order to a program, from the first screen and back."""
    if order.order == "start":
        ups = order.number - 1
    elif order.order == "jump":
        ups = _CHOICES["jump"] + order.number - 1
    else:
        ups = _CHOICES[order.order]
    selects = 1 if order.order in _AT_ONCE else 2
    return (*_TO_PROGRAM, *["up"] * ups, *["select"] * selects, *_FROM_PROGRAM)


class Fingers:
    """Somebody who presses one key after the other, each 0.1 s down and 0.1 s up."""

    def __init__(self, keypad: Keypad, clock_hz: int) -> None:
        self._keypad = keypad
        self._press_cycles = round(PRESS_S * clock_hz)
        self._moves: deque[str | None] = deque()
        self.wake_cycle: int | None = None
        """When a finger moves next; None: never."""

    def play(self, keys: Iterable[str], now_cycle: int) -> None:
        """Press these keys, after those that still wait."""
        for key in keys:
            self._moves += (key, None)
        if self.wake_cycle is None and self._moves:
            self.wake_cycle = now_cycle

    def move(self, now_cycle: int) -> None:
        """Press or let go what is due."""
        while self.wake_cycle is not None and self.wake_cycle <= now_cycle:
            if not self._moves:
                self.wake_cycle = None
                return
            self._keypad.press(self._moves.popleft())
            self.wake_cycle += self._press_cycles
