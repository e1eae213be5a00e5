"""The response of a loop to its last setpoint (docs/control.md, "Response")."""

from heatwright.sim.reference.numbers import ZERO, Kept, Single, period, steps
from heatwright.spec import Loop

NONE, OUTSIDE, INSIDE, SETTLED = range(4)
MOST_STEPS = 65535


class Response(Kept):
    """Measures settling time and overshoot."""

    def __init__(self, within_k: float, for_s: float, loop: Loop) -> None:
        """Derive the constants; nothing is measured yet."""
        self.keep(
            ("state", "u1", "_state"),
            ("rising", "u1", "_rising"),
            ("measured", "u1", "_measured"),
            ("steps", "u2", "_steps"),
            ("entered", "u2", "_entered"),
            ("target_c", "f4", "_target"),
            ("beyond_k", "f4", "_beyond"),
            ("settling_s", "f4", "_settling_s"),
            ("overshoot_k", "f4", "_overshoot"),
        )
        self._within = Single(within_k)
        self._least_steps = steps(for_s, loop)
        self._period_s = period(loop)
        self._state = NONE
        self._rising = self._measured = self._steps = self._entered = 0
        self._target = self._beyond = self._settling_s = self._overshoot = ZERO

    def step(self, temperature_c: Single | None, setpoint_c: Single, *, held: bool) -> None:
        """Process a step; the temperature is None without a reading."""
        if not held:
            self._state = NONE
            return
        another = self._state == NONE or bool(setpoint_c != self._target)
        if not another:
            self._steps = min(self._steps + 1, MOST_STEPS)
        if temperature_c is None:
            return
        if another:
            self._begin(temperature_c, setpoint_c)
        if self._state != SETTLED and self._steps < MOST_STEPS:
            self._look(temperature_c)

    def _begin(self, temperature_c: Single, setpoint_c: Single) -> None:
        moving = self._state != NONE and self._steps == 0
        self._rising = int((self._target if moving else temperature_c) < setpoint_c)
        self._state, self._target = OUTSIDE, setpoint_c
        self._steps = self._entered = 0
        self._beyond = ZERO

    def _look(self, temperature_c: Single) -> None:
        error = temperature_c - self._target
        self._beyond = max(self._beyond, error if self._rising else -error)
        if abs(error) > self._within:
            self._state = OUTSIDE
            return
        if self._state == OUTSIDE:
            self._state, self._entered = INSIDE, self._steps
        if self._steps - self._entered >= self._least_steps:
            self._state = SETTLED
            self._settling_s = Single(self._entered) * self._period_s
            self._overshoot = self._beyond
            self._measured = (self._measured + 1) & 0xFF


def response_of(loop: Loop) -> Response | None:
    """Return the measurement of a loop's response; None if the spec has none."""
    if loop.response is None:
        return None
    return Response(loop.response.within_k, loop.response.for_s, loop)
