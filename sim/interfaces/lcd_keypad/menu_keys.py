"""The keys of the LCD keypad shield that give a command in the menu of a loop with programs.

Each sequence of keys begins and ends at the first screen. RIGHT of it are the screens of the times
and of the program; LEFT of it are the single values. A screen forgets its state when it is left.
"""

from collections import deque
from collections.abc import Iterable

from heatwright.sim.interfaces.lcd_keypad.keypad import Keypad
from heatwright.sim.scenario import PRESS_S
from heatwright.spec import ProgramOrder

_TO_PROGRAM, _FROM_PROGRAM = ("right", "right"), ("left", "left")
_CHOICES = {"pause": 0, "resume": 0, "skip": 1, "stop": 2, "jump": 3}
"""How often UP is pressed for each command to a running program; `jump 1` goes to its first
segment."""
_AT_ONCE = ("pause", "resume")
"""Commands that need no confirmation; all others ask for one."""


def keys_for(order: ProgramOrder) -> tuple[str, ...]:
    """Return the key presses that give a command to a program, from the first screen and back."""
    if order.order == "start":
        ups = order.number - 1
    elif order.order == "jump":
        ups = _CHOICES["jump"] + order.number - 1
    else:
        ups = _CHOICES[order.order]
    selects = 1 if order.order in _AT_ONCE else 2
    return (*_TO_PROGRAM, *["up"] * ups, *["select"] * selects, *_FROM_PROGRAM)


class Fingers:
    """Presses one key after the other, each 0.1 s down and 0.1 s up."""

    def __init__(self, keypad: Keypad, clock_hz: int) -> None:
        self._keypad = keypad
        self._press_cycles = round(PRESS_S * clock_hz)
        self._moves: deque[str | None] = deque()
        self.wake_cycle: int | None = None
        """The cycle of the next press or release; None: there is none."""

    def play(self, keys: Iterable[str], now_cycle: int) -> None:
        """Press these keys, after those that still wait."""
        for key in keys:
            self._moves += (key, None)
        if self.wake_cycle is None and self._moves:
            self.wake_cycle = now_cycle

    def move(self, now_cycle: int) -> None:
        """Press or release the key that is due."""
        while self.wake_cycle is not None and self.wake_cycle <= now_cycle:
            if not self._moves:
                self.wake_cycle = None
                return
            self._keypad.press(self._moves.popleft())
            self.wake_cycle += self._press_cycles
