"""Stretches of a course: readings that move, jump, are missing, or stand still."""

from random import Random
from typing import Any, NamedTuple

import numpy as np
from host_values import scale_of
from numpy.typing import NDArray

from heatwright.sim.host.firmware import INPUT, Command
from heatwright.spec import Controller, Loop, ThreePosition, facts_of

LONGEST = 2000  # steps of a course


NO_GAINS = (0.0, 0.0, 0.0)
NO_COMMAND = (Command.NOTHING, 0.0, NO_GAINS)
NOT_WARM = 0  # what is monitored, until `fill_monitors` warms it
ALL_CLOSED = 0  # the machine's inputs, until `fill_inputs` opens one
NO_ORDER = (0, 0)
AS_DUE = 100  # per cent of the current that is due: a healthy heater


class Stretch(NamedTuple):
    """A few steps of one kind; what `value` and `nudge` mean depends on it."""

    kind: str
    steps: int
    value: int
    nudge: int = 0  # codes beside the place where a rule begins to hold
    acknowledge: bool = False


class Walk:
    def __init__(self, controller: Controller) -> None:
        ((name, loop),) = controller.loops.items()
        protection = loop.protection
        self._scale = scale_of(controller)
        self._commanded = facts_of(controller, name).commanded
        self._raw = self._scale.first
        self._setpoint_c = loop.setpoint.initial_c
        self._setpoints_c = (
            loop.setpoint.minimum_c, loop.setpoint.maximum_c, 20.0, 35.5, 50.0, 0.1 + 0.2 + 40,
        )  # fmt: skip
        self._fastest_k = protection.rise_rate_k_per_s * loop.period_s
        self._fixed_c = (protection.maximum_c, protection.minimum_c)
        self._offsets_k = _offsets_k(loop)
        self._rises_k = [
            rule.rise_k for rule in (protection.heating, protection.rising_while_off) if rule
        ] or [1.0]
        self._missing = 0
        self._last_good = self._scale.first
        self._taken = 0  # what the firmware has, which begins with 0
        self._rows: list[tuple[Any, ...]] = []
        self._command: tuple[Any, ...] = NO_COMMAND
        self._waiting: list[tuple[Any, ...]] = []
        self._others = (0, AS_DUE, 0)
        self._acknowledges = False
        self._ordered: tuple[int, int] = NO_ORDER

    def inputs(self, course: list[Stretch]) -> NDArray[Any]:
        for stretch in course:
            self._acknowledges = stretch.acknowledge or stretch.kind.startswith("tune")
            if stretch.acknowledge:
                self._go_on()
            getattr(self, f"_{stretch.kind}")(stretch)
        return np.array([(*row, ALL_CLOSED, NOT_WARM) for row in self._rows], INPUT)

    def _go_on(self) -> None:
        """Do what it takes to heat again after an acknowledgement."""

    def _good(self, raw: int) -> None:
        self._raw = max(self._scale.lowest, min(self._scale.highest, raw))
        self._append(0, self._raw)
        self._last_good, self._taken, self._missing = self._raw, self._raw, 0

    def _missed(self, status: int) -> None:
        self._missing += 1
        self._append(status, self._taken)

    def _append(self, status: int, raw: int) -> None:
        if self._waiting and self._command == NO_COMMAND:
            self._command = self._waiting.pop(0)
        acknowledge = int(self._acknowledges)
        self._acknowledges = False
        reading = (status, acknowledge, raw, self._setpoint_c)
        self._add((*reading, *self._command, *self._others, *self._ordered))
        self._command, self._ordered = NO_COMMAND, NO_ORDER

    def _add(self, row: tuple[Any, ...]) -> None:
        self._rows.append(row)

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
        self._ramp_to(places_c[stretch.value % len(places_c)], stretch.nudge)
        self._hold(stretch)

    def _leave(self, stretch: Stretch) -> None:
        """Be at the setpoint, then leave the band about it for a while."""
        self._ramp_to(self._setpoint_c)
        self._reach(stretch._replace(value=stretch.value | 1))

    def _swing(self, stretch: Stretch) -> None:
        """Let an integral grow a little below the setpoint, then pass it upwards and downwards."""
        goal_c, height_k = self._setpoint_c, abs(stretch.value) / 16
        self._ramp_to(goal_c - abs(stretch.value) // 2 / 16)
        for number in range(3 * stretch.steps):
            self._good(self._raw + (-1) ** number)
        self._ramp_to(goal_c + height_k)
        self._ramp_to(goal_c - height_k)

    def _rise_by(self, stretch: Stretch) -> None:
        """Rise from here by what a rule waits for, in steps of a drift."""
        rise_k = self._rises_k[stretch.value % len(self._rises_k)]
        self._hold(stretch)
        self._ramp_to(self._scale.celsius(self._raw) + rise_k, stretch.nudge)

    def _ramp_to(self, goal_c: float, nudge: int = 0, slower: float = 1.0) -> None:
        goal, fastest_k = self._scale.code(goal_c) + nudge, self._fastest_k / slower
        self._good(self._last_good)
        while self._raw != goal and len(self._rows) < LONGEST:
            before = self._raw
            far = self._towards(goal, fastest_k)
            self._good(goal if far == before else far)
            if self._raw == before:
                return  # as far as codes go

    def _towards(self, goal: int, fastest_k: float) -> int:
        """Return the code that is as near to another as one step may take it."""
        left_k = self._scale.celsius(goal) - self._scale.celsius(self._raw)
        if abs(left_k) <= fastest_k:
            return goal
        return self._scale.moved(self._raw, fastest_k if left_k > 0 else -fastest_k)

    def _jump(self, stretch: Stretch) -> None:
        """Change by just what is allowed since the last good reading."""
        change_k = self._fastest_k * (min(self._missing, 255) + 1)
        up = stretch.value > 0
        place = self._scale.moved(self._last_good, change_k if up else -change_k)
        self._good(place + (stretch.nudge if place >= self._last_good else -stretch.nudge))

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
            self._good(random.randint(*self._scale.noise))

    def _wild(self, stretch: Stretch) -> None:
        random = Random(stretch.value)  # noqa: S311
        for _ in range(stretch.steps):
            if random.random() < 0.5:
                self._missed(random.randint(1, 5))
            else:
                self._good(random.randint(self._scale.lowest, self._scale.highest))

    def _setpoint(self, stretch: Stretch) -> None:
        self._set(self._setpoints_c[stretch.value % len(self._setpoints_c)])
        self._hold(stretch)

    def _set(self, setpoint_c: float) -> None:
        if not self._commanded or setpoint_c != 0:
            self._setpoint_c = setpoint_c
        self._command = (Command.SET, setpoint_c, NO_GAINS)


def _offsets_k(loop: Loop) -> list[float]:
    """Where rules and algorithm change their mind, from the setpoint."""
    algorithm, runaway = loop.algorithm, loop.protection.runaway
    offsets_k = [0.0, getattr(algorithm, "hysteresis_k", 0.0)]
    if runaway is not None:
        offsets_k += [runaway.above_k, -(runaway.below_k or 0.0)]
    offsets_k.append(-offsets_k[1])
    for band_k in (getattr(algorithm, "band_k", None), getattr(algorithm, "dead_band_k", None)):
        if band_k:
            offsets_k += [band_k, -band_k]
    if isinstance(algorithm, ThreePosition):
        inside_k = algorithm.dead_band_k - algorithm.hysteresis_k
        offsets_k += [inside_k, -inside_k]
    if loop.ready_within_k:
        offsets_k += [loop.ready_within_k, -loop.ready_within_k]
    return offsets_k
