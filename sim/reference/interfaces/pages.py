"""The display pages on which keys change a value: the setpoint, a countdown, or a number.

See docs/control.md, "Keys", "Numbers" and "Countdown". A loop with programs has a menu instead.
"""

from heatwright.sim.reference.interfaces.keyed import given
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.numbers import Single, clamp, period_us
from heatwright.spec import Loop
from heatwright.spec.adjusted import Number
from heatwright.spec.interfaces import Countdown

MINUTE_MS = 60_000


class CountdownKeys:
    """The remaining time, and the keys that set it."""

    def __init__(self, spec: Countdown, loop: Loop, operator: SwitchedOperator) -> None:
        """Start without a time."""
        self._operator = operator
        self._step = round(spec.step_s) // 60
        self._longest = round(spec.longest_s) // 60
        self._at_once = spec.counts == "at once"
        self._period_ms = period_us(loop) // 1000
        self.minutes = 0
        self.left: int | None = None
        """Steps until the loop goes off; None while the countdown does not run."""
        self.ended = False
        """Whether the countdown has switched the loop off, until it is on again."""

    @property
    def minutes_left(self) -> int:
        """The remaining minutes, rounded up, or the set time."""
        if self.left is None:
            return self.minutes
        return -(-self.left * self._period_ms // MINUTE_MS)

    def change(self, *, up: bool) -> None:
        """Press UP or DOWN."""
        by = self._step if up else -self._step
        wanted = min(self.minutes_left + by, self._longest)
        if self.left is None:
            self.minutes = max(wanted, 0)
        elif wanted > 0:
            self.left = self._steps(wanted)

    def after_step(self, *, warm: bool) -> None:
        """Count a step; warm -- whether the loop was near its setpoint in it."""
        if self._operator.is_off:
            self.left = None
            return
        self.ended = False
        if self.left is not None:
            self.left -= 1
            if self.left <= 0:
                self.left = None
                self.ended = True
                self._operator.key_off()
        elif self.minutes and (warm or self._at_once):
            self.left = self._steps(self.minutes)

    def _steps(self, minutes: int) -> int:
        return minutes * MINUTE_MS // self._period_ms


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
