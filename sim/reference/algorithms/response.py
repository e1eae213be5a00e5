"""The response of a loop to its last setpoint (docs/control.md, "Response")."""

from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single, period, steps
from heatwright.spec import Loop

NONE, OUTSIDE, INSIDE, SETTLED = range(4)
MOST_STEPS = 65535


class Response:
    """Measures settling time and overshoot."""

    members: tuple[Member, ...] = (
        ("state", "u1"),
        ("rising", "u1"),
        ("measured", "u1"),
        ("steps", "u2"),
        ("entered", "u2"),
        ("target_c", "f4"),
        ("beyond_k", "f4"),
        ("settling_s", "f4"),
        ("overshoot_k", "f4"),
    )

    def __init__(self, within_k: float, for_s: float, loop: Loop) -> None:
        """Derive the constants; nothing is measured yet."""
        self._within = Single(within_k)
        self._long = steps(for_s, loop)
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

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (
            self._state,
            self._rising,
            self._measured,
            self._steps,
            self._entered,
            self._target,
            self._beyond,
            self._settling_s,
            self._overshoot,
        )

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
        if self._steps - self._entered >= self._long:
            self._state = SETTLED
            self._settling_s = Single(self._entered) * self._period_s
            self._overshoot = self._beyond
            self._measured = (self._measured + 1) & 0xFF


def response_of(loop: Loop) -> Response | None:
    """Return the measurement of a loop's response; None if the spec has none."""
    if loop.response is None:
        return None
    return Response(loop.response.within_k, loop.response.for_s, loop)
