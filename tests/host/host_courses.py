"""Courses of readings, setpoints and acknowledgements, made of a few kinds of stretches."""

from random import Random
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.host.firmware import INPUT
from heatwright.spec import Loop

KINDS = (
    "hold", "drift", "reach", "rise_by", "jump", "miss", "lose", "noise", "wild", "setpoint",
    "zigzag", "leave", "swing",
)  # fmt: skip
LOWEST_RAW, HIGHEST_RAW = -55 * 16, 125 * 16


class Stretch(NamedTuple):
    """A few steps of one kind; what `value` and `nudge` mean depends on it."""

    kind: str
    steps: int
    value: int
    nudge: int = 0
    """Codes beside the place where a rule begins to hold."""
    acknowledge: bool = False


LONG_SILENCE = [
    Stretch("setpoint", 1, 3),
    Stretch("leave", 3, 1),
    Stretch("lose", 1, 8),
    Stretch("drift", 3, 40, acknowledge=True),
]
"""The readings come back after more steps than eight bits can count."""

LOWERED = [
    Stretch("setpoint", 1, 3),
    Stretch("swing", 10, 20, acknowledge=True),
    Stretch("zigzag", 12, 20, acknowledge=True),
    Stretch("setpoint", 1, 0),
    Stretch("reach", 2, 1),
]
"""A charged integral, the setpoint lowered, the temperature falling fast: the duty is at its
maximum although the error is negative."""


def random_course(random: Random, stretches: int) -> list[Stretch]:
    return [
        Stretch(
            random.choice(KINDS),
            random.randint(1, 14),
            random.randint(-200, 200),
            random.choice((-1, 0, 0, 1)),
            random.random() < 0.5,
        )
        for _ in range(stretches)
    ]


def inputs_of(loop: Loop, course: list[Stretch]) -> NDArray[Any]:
    """The steps of a course; a failed reading leaves the code as it was, as the firmware does."""
    return _Walk(loop).inputs(course)


class _Walk:
    def __init__(self, loop: Loop) -> None:
        protection = loop.protection
        self._raw = 0
        self._setpoint_c = loop.setpoint.initial_c
        self._setpoints_c = (
            loop.setpoint.minimum_c, loop.setpoint.maximum_c, 20.0, 35.5, 50.0, 0.1 + 0.2 + 40,
        )  # fmt: skip
        self._fastest = int(protection.rise_rate_k_per_s * loop.period_s * 16)
        self._fixed_c = (protection.maximum_c, protection.minimum_c)
        runaway = protection.runaway
        self._offsets_k = [0.0, getattr(loop.algorithm, "hysteresis_k", 0.0)]
        if runaway is not None:
            self._offsets_k += [runaway.above_k, -(runaway.below_k or 0.0)]
        self._offsets_k.append(-self._offsets_k[1])
        self._rises_k = [
            rule.rise_k for rule in (protection.heating, protection.rising_while_off) if rule
        ] or [1.0]
        self._missing = 0
        self._last_good = 0
        self._rows: list[tuple[int, int, int, float]] = []

    def inputs(self, course: list[Stretch]) -> NDArray[Any]:
        for stretch in course:
            begin = len(self._rows)
            getattr(self, f"_{stretch.kind}")(stretch)
            if stretch.acknowledge:
                status, _, raw, setpoint_c = self._rows[begin]
                self._rows[begin] = (status, 1, raw, setpoint_c)
        return np.array(self._rows, INPUT)

    def _good(self, raw: int) -> None:
        self._raw = max(-(2**15), min(2**15 - 1, raw))
        self._rows.append((0, 0, self._raw, self._setpoint_c))
        self._last_good, self._missing = self._raw, 0

    def _missed(self, status: int) -> None:
        self._missing += 1
        self._rows.append((status, 0, self._last_good, self._setpoint_c))

    def _hold(self, stretch: Stretch) -> None:
        for _ in range(stretch.steps):
            self._good(self._raw)

    def _drift(self, stretch: Stretch) -> None:
        for _ in range(stretch.steps):
            self._good(self._raw + stretch.value // 20)

    def _zigzag(self, stretch: Stretch) -> None:
        for number in range(stretch.steps):
            self._good(self._raw + (-1) ** number * (stretch.value // 20))

    def _reach(self, stretch: Stretch) -> None:
        """Go, no faster than may be, to where a rule or the switch changes its mind."""
        places_c = [self._setpoint_c + each for each in self._offsets_k]
        if stretch.value % 7 == 0:
            places_c = list(self._fixed_c)
        self._ramp(round(places_c[stretch.value % len(places_c)] * 16) + stretch.nudge)
        self._hold(stretch)

    def _leave(self, stretch: Stretch) -> None:
        """Be at the setpoint, then leave the band about it for a while."""
        self._ramp(round(self._setpoint_c * 16))
        self._reach(stretch._replace(value=stretch.value | 1))

    def _swing(self, stretch: Stretch) -> None:
        """Let an integral grow a little below the setpoint, then pass it upwards and downwards."""
        goal = round(self._setpoint_c * 16)
        self._ramp(goal - abs(stretch.value) // 2)
        for number in range(3 * stretch.steps):
            self._good(self._raw + (-1) ** number)
        self._ramp(goal + abs(stretch.value))
        self._ramp(goal - abs(stretch.value))

    def _rise_by(self, stretch: Stretch) -> None:
        """Rise from here by what a rule waits for, in steps of a drift."""
        rise_k = self._rises_k[stretch.value % len(self._rises_k)]
        self._hold(stretch)
        self._ramp(self._raw + round(rise_k * 16) + stretch.nudge)

    def _ramp(self, goal: int) -> None:
        self._good(self._last_good)
        while self._raw != goal and len(self._rows) < 2000:
            step = max(-self._fastest, min(self._fastest, goal - self._raw))
            self._good(self._raw + step)

    def _jump(self, stretch: Stretch) -> None:
        """Change by just what is allowed since the last good reading."""
        change = self._fastest * (min(self._missing, 255) + 1) + stretch.nudge
        self._good(self._last_good + (change if stretch.value > 0 else -change))

    def _miss(self, stretch: Stretch) -> None:
        for number in range(stretch.steps):
            self._missed(1 + (stretch.value + number) % 5)

    def _lose(self, stretch: Stretch) -> None:
        """Lose readings for longer than eight bits can count, now and then."""
        steps = 262 if stretch.value % 8 == 0 else 1
        for _ in range(steps):
            self._missed(1 + stretch.value % 5)

    def _noise(self, stretch: Stretch) -> None:
        random = Random(stretch.value)  # noqa: S311
        for _ in range(stretch.steps):
            self._good(random.randint(LOWEST_RAW, HIGHEST_RAW))

    def _wild(self, stretch: Stretch) -> None:
        random = Random(stretch.value)  # noqa: S311
        for _ in range(stretch.steps):
            if random.random() < 0.5:
                self._missed(random.randint(1, 5))
            else:
                self._good(random.randint(-(2**15), 2**15 - 1))

    def _setpoint(self, stretch: Stretch) -> None:
        self._setpoint_c = self._setpoints_c[stretch.value % len(self._setpoints_c)]
        self._hold(stretch)
