"""The display pages on which keys change a value (docs/control.md, "Keys" and "Numbers")."""

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
