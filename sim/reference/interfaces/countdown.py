"""The countdown after which a loop goes off, set at the keypad (docs/control.md, "Countdown")."""

from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.numbers import period_us
from heatwright.spec import Loop
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
