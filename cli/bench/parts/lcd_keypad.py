"""The display shield: two lines of text, and five keys."""

from typing import Any

from heatwright.cli.bench.parts.seat import BadOrder, Live, Order, Seat, flag_of, number_of
from heatwright.cli.bench.world import LiveWorld
from heatwright.sim.interfaces.lcd_keypad.keypad import CODES
from heatwright.sim.scenario import PRESS_S
from heatwright.spec import Controller

KEYS = tuple(key for key in CODES if key is not None)
BRISK_S = 0.4
"""Longest press, in s of board time, that is recorded as a scenario's `press`; for the firmware a
longer press is a held key."""
LONGEST_HOLD_S = 60.0


class Shield(Seat):
    """A person at the display shield."""

    kind = "lcd_keypad"

    def __init__(self, controller: Controller, number: int) -> None:
        super().__init__(controller, number)
        self._down: tuple[str, float] | None = None
        self._free_s = 0.0
        self._lifted: set[str] = set()
        """Keys still held on the page, but released on the board because another was pressed."""

    def about(self) -> dict[str, Any]:
        """Return the keys."""
        return {"keys": list(KEYS)}

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return both lines of the display, and the key that is held."""
        shield = self.part(world)
        del shield.lcd.history[:-1]
        return {"rows": list(shield.lcd.text), "held": shield.keypad.held}

    def act(self, live: Live, order: Order) -> None:
        """Press a key or release it.

        A board faster than real time is too fast for a finger: the press reaches it on release, and
        lasts as long in board time as the finger held it. A press waits until the previous key has
        been released for PRESS_S, so that the firmware sees both.
        """
        key = order.get("key")
        if key not in KEYS:
            raise BadOrder(f"There is no such key; there are {', '.join(KEYS)}.")
        if flag_of(order, "down"):
            if not live.is_quick:
                self._press(live, key)
            return
        finger_s = number_of(order, "held_s", 0.0, LONGEST_HOLD_S)
        if key in self._lifted:
            self._lifted.remove(key)
            return
        if self._down is None or self._down[0] != key:
            self._press(live, key)
        self._let_go(live, finger_s if live.is_quick else 0.0)

    def _press(self, live: Live, key: str) -> None:
        if self._down is not None and self._down[0] != key:  # one finger: release the other key
            self._lifted.add(self._down[0])
        self._lifted.discard(key)
        self._let_go(live)
        since_s = max(live.world.now_s, self._free_s)
        self._at(live, since_s, key)
        self._down = key, since_s

    def _let_go(self, live: Live, finger_s: float = 0.0) -> None:
        if self._down is None:
            return
        key, since_s = self._down
        held_s = max(PRESS_S, live.world.now_s - since_s, finger_s)
        self._at(live, since_s + held_s, None)
        self._down = None
        self._free_s = since_s + held_s + PRESS_S
        held = {"held": f"{held_s:.2f} s"} if held_s >= BRISK_S else {}
        live.record({"at_s": since_s, "press": key, **held})

    def _at(self, live: Live, time_s: float, key: str | None) -> None:
        device = live.world.device
        if time_s <= live.world.now_s:
            device.press(key)
        else:
            live.later(time_s - live.world.now_s, lambda: device.press(key))


take = Shield
