"""Five keys with resistors on one analog input, and the key presses that give commands in the menu.

Each sequence of keys begins and ends at the first screen. RIGHT of it are the screens of the times
and of the program; LEFT of it are the single values. A screen forgets its state when it is left.
"""

import random
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence

from heatwright.sim.avr import Avr
from heatwright.sim.native.analog import millivolts
from heatwright.sim.scenario import PRESS_S
from heatwright.spec import ProgramOrder

CODES: Mapping[str | None, int] = {
    "right": 0, "up": 131, "down": 307, "left": 481, "select": 722, None: 1023,
}  # fmt: skip
"""Nominal ADC codes of the LCD keypad shield; None: no key."""

BOUNCE_S = 0.001


class Keypad:
    """The keys of the shield on an ADC channel.

    tolerance -- the codes' common relative error, from the resistors; bounces -- how often a
    contact bounces when it closes or opens, every BOUNCE_S.
    """

    def __init__(
        self, avr: Avr, channel: int = 0, *, tolerance: float = 0.0, bounces: int = 0
    ) -> None:
        self.held: str | None = None
        self._avr = avr
        self._channel = channel
        self.tolerance = tolerance
        self.bounces = bounces
        self._pending: list[tuple[int, str | None]] = []
        self._set(None)

    def press(self, key: str | None) -> None:
        """Hold a key from now on: right, up, down, left, select; None: none.

        Raises ValueError: it is another name.
        """
        if key not in CODES:
            raise ValueError(f"There is no key {key}; there are right, up, down, left, select.")
        self._pending = list(self._bouncing(key))
        self.held = key
        self._set(key)

    def flicker(self, keys: Sequence[str | None], dwells_s: Sequence[float], for_s: float) -> None:
        """Simulate a leak: keys seem to be pressed at random, and none is released for long.

        keys, dwells_s -- the keys that seem pressed, and the times for which each seems so, s;
        for_s -- duration of the leak, s.
        """
        chance = random.Random(len(keys))  # noqa: S311 - noise, not a secret
        cycle, self._pending = self._avr.cycle, []
        end = cycle + round(for_s * self._avr.clock_hz)
        while cycle < end:
            for key in (chance.choice(keys), None):
                self._pending.append((cycle, key))
                cycle += round(chance.choice(dwells_s) * self._avr.clock_hz)

    def _bouncing(self, key: str | None) -> Iterator[tuple[int, str | None]]:
        step = round(BOUNCE_S * self._avr.clock_hz)
        for turn in range(2 * self.bounces):
            yield self._avr.cycle + (turn + 1) * step, key if turn % 2 else self.held

    @property
    def wake_cycle(self) -> int | None:
        """The cycle of the next bounce or flicker of a key, if there is one."""
        return self._pending[0][0] if self._pending else None

    def advance(self, cycle: int) -> None:
        """Run the processor to a cycle, with all bounces and flickers before it."""
        while self._pending and self._pending[0][0] <= cycle:
            self._avr.run_to(self._pending[0][0])
            self._set(self._pending.pop(0)[1])
        self._avr.run_to(cycle)

    def _set(self, key: str | None) -> None:
        code = CODES[key] if key is None else CODES[key] * (1 + self.tolerance)
        self._avr.adc.set(self._channel, millivolts(min(code, 1023)))


_TO_PROGRAM, _FROM_PROGRAM = ("right", "right"), ("left", "left")
_CHOICES = {"pause": 0, "resume": 0, "skip": 1, "stop": 2, "jump": 3}
"""How often UP is pressed for each command to a running program; `jump 1` goes to its first
segment."""
_AT_ONCE = ("pause", "resume")
"""Commands that need no confirmation; all others need one."""


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
