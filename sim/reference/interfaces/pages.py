"""The display pages on which keys change a value (docs/control.md, "Keys" and "Numbers").

A loop with programs has a menu in their place.
"""

from heatwright.sim.reference.interfaces.countdown import CountdownKeys
from heatwright.sim.reference.interfaces.keyed import given
from heatwright.sim.reference.numbers import Single, clamp
from heatwright.spec.adjusted import Number

TIME = "time"


class Pages:
    """The value that UP and DOWN change: the setpoint, the countdown's time, or a number."""

    def __init__(self, countdown: CountdownKeys | None, numbers: tuple[Number, ...]) -> None:
        """Start at the page of the setpoint."""
        self._countdown = countdown
        self._numbers = {each.kind.key: each for each in numbers}
        self._pages = ("", *(TIME,) * (countdown is not None), *self._numbers)
        self.page = ""
        """`time`, the key of a number, or "": the setpoint."""
        self.values = given(numbers)

    def take(self, key: str | None) -> bool:
        """Process a key press; return False if the loop must process it instead."""
        if key == "right":
            self.page = self._pages[(self._pages.index(self.page) + 1) % len(self._pages)]
            return True
        if self._numbers and key in ("left", "select"):
            self.page = ""
        if key not in ("up", "down") or not self.page:
            return False
        if self._countdown is not None and self.page == TIME:
            self._countdown.change(up=key == "up")
        else:
            self._change(self._numbers[self.page], up=key == "up")
        return True

    def _change(self, number: Number, *, up: bool) -> None:
        field, step = number.kind.field, Single(number.step)
        now = self.values[field]
        wanted = now + step if up else now - step
        self.values[field] = clamp(wanted, Single(number.minimum), Single(number.maximum))


STATE, TIMES, RUN, EDIT, VALUES = range(5)
"""The screens, in the order in which RIGHT shows them."""
SCREENS = 5


class MenuKeys:
    """The present screen of the menu at the keypad of a loop with programs.

    The model knows only one function of the screens: the setpoint, which is the first of the
    values. Programs are started and ended by commands, not by keys.
    """

    def __init__(self) -> None:
        """Start at the screen with the state."""
        self._screen = STATE
        self._is_first = True

    def moves(self, key: str | None) -> int:
        """Process a key press; return by how many key steps it changes the setpoint."""
        if key in {"left", "right"}:
            self._screen = (self._screen + (1 if key == "right" else -1)) % SCREENS
            self._is_first = True
        elif key == "select":
            self._is_first = False
        elif self._screen == VALUES and self._is_first:
            return {"up": 1, "down": -1}.get(key or "", 0)
        return 0
