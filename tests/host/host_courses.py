"""Courses of readings, setpoints, commands and acknowledgements, of a few kinds of stretches."""

from random import Random
from typing import Any, NamedTuple

import numpy as np
from host_reference import fill_currents
from host_scale import scale_of
from numpy.typing import NDArray

from heatwright.sim.host.firmware import INPUT, Command
from heatwright.spec import Controller, Current, Loop, ThreePosition, commanded
from heatwright.spec.commands import switched

KINDS = (
    "hold", "drift", "reach", "rise_by", "jump", "miss", "lose", "noise", "wild", "setpoint",
    "zigzag", "leave", "swing",
)  # fmt: skip
COMMAND_KINDS = (
    "setpoint", "order", "manual", "gains", "gains", "off_and_on", "tune", "tune_in_part",
)  # fmt: skip
"""What else a course of a commanded loop is made of; on others they hold."""


SWITCH_KINDS = ("switch", "order_switched", "by_percent", "silence")
"""Of a switched loop, besides."""
CURRENT_KINDS = ("load", "load", "leak", "over", "no_scan")
"""Where the heater's current is measured, besides."""


class Stretch(NamedTuple):
    """A few steps of one kind; what `value` and `nudge` mean depends on it."""

    kind: str
    steps: int
    value: int
    nudge: int = 0
    """Codes beside the place where a rule begins to hold."""
    acknowledge: bool = False


LONGEST = 2000
"""Steps of a course."""

CODES_PER_AMPERE = 4096 / 25
"""Of the sum of four codes at 0.2 V/A and 5 V, as host_switched has it; 0 A is at -2 codes."""
IDLE_CODES = 10
"""The sum that is just three steps of the ADC."""

NO_GAINS = (0.0, 0.0, 0.0)
NO_COMMAND = (Command.NOTHING, 0.0, NO_GAINS)
ORDERS: tuple[tuple[Any, ...], ...] = (
    *((Command.SET, value, NO_GAINS) for value in (0.0, -0.0, -1.0, 1e4, float("nan"), 30.0)),
    *((Command.MANUAL, value, NO_GAINS) for value in (0.0, 100.0, 100.5, -0.5, float("nan"))),
    *((Command.TUNE, value, (cycles, 0, 0)) for value, cycles in ((50, 0), (60, 255), (0, 5))),
    *((Command.TUNE, value, (5, 0, 0)) for value in (float("nan"), 1e4)),
    *((each, 0.0, NO_GAINS) for each in (
        Command.STOP_TUNING, Command.KEEP, Command.RELOAD, Command.DEFAULTS, Command.EMERGENCY,
    )),
)  # fmt: skip

SWITCHED_ORDERS: tuple[tuple[Any, ...], ...] = (
    *ORDERS,
    *((each, 0.0, NO_GAINS) for each in (Command.ENABLE, Command.DISABLE, Command.AUTOMATIC)),
    *((Command.PERCENT, value, NO_GAINS) for value in (0.0, 100.0, 100.5, -0.5, float("nan"))),
)
SHARES = (300, 150, 75, 60, 50, 49, 30, 10, 0, 1000)
"""Of the current that is due, %."""
AS_DUE = 100

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


TUNED_C = 45.0
_SWING = [("to", 3.0), ("to", -4.0)]
_SLOW_SWING = [("to", 3.0), ("slowly", -4.0)]
_UP = ("to", -22.0)
_DOWN_AND_GONE = [("to", -25.0), ("to", -9.5), ("to", -24.0), ("gone", 8)]
"""Into the measurement of the slope, and down: the next reading may be 27 K higher."""
TUNINGS: tuple[list[tuple[str, float]], ...] = (
    [("to", -19.9375), ("still", 2), ("to", -20), ("to", -10), ("to", 0), ("to", -1), *_SWING * 6],
    [_UP, ("to", 5), *_SWING * 2, ("gone", 3), *_SWING * 4],
    [_UP, ("to", 19.9375), ("still", 2), ("to", 20), ("still", 2)],
    [("to", 25), ("still", 3), ("to", -25), ("to", 8), ("to", -7), ("to", 7), ("still", 3)],
    [_UP, ("to", 5), ("to", -3), ("still", 1250)],
    [_UP, ("to", -5), ("gone", 15), ("still", 3), ("to", 3), ("to", -6), *_SWING * 5],
    [_UP, ("to", -11), ("gone", 6), ("at", 1), ("gone", 2), ("still", 2), ("to", 3), *_SWING * 6],
    [*_DOWN_AND_GONE, ("at", 0), *_SWING * 6],
    [*_DOWN_AND_GONE[:3], ("wobble", 1000), *_DOWN_AND_GONE[2:], ("at", 1.0625), *_SLOW_SWING * 6],
    [_UP, ("to", 2), ("to", -1), *_SWING * 6, ("still", 3)],
)
"""What the experiment has to bear: see _tune_by_hand. A step of the chip is 0.0625 K."""


def random_course(random: Random, stretches: int, kinds: tuple[str, ...] = KINDS) -> list[Stretch]:
    return [
        Stretch(
            random.choice(kinds),
            random.randint(1, 14),
            random.randint(-200, 200),
            random.choice((-1, 0, 0, 1)),
            random.random() < 0.5,
        )
        for _ in range(stretches)
    ]


def inputs_of(controller: Controller, course: list[Stretch]) -> NDArray[Any]:
    """The steps of a course; a failed reading leaves the code as it was, as the firmware does."""
    inputs = _Walk(controller).inputs(course)
    if current_of(controller):
        fill_currents(controller, inputs)
    return inputs


def current_of(controller: Controller) -> Current | None:
    ((_, loop),) = controller.loops.items()
    return getattr(controller.outputs[loop.heater], "current", None)


def kinds_of(controller: Controller) -> tuple[str, ...]:
    """The kinds of stretches that a controller has something to answer to."""
    ((name, _),) = controller.loops.items()
    kinds = KINDS + COMMAND_KINDS * (2 * commanded(controller, name))
    kinds += SWITCH_KINDS * (2 * switched(controller, name))
    return kinds + CURRENT_KINDS * (2 * (current_of(controller) is not None))


class _Walk:
    def __init__(self, controller: Controller) -> None:
        ((name, loop),) = controller.loops.items()
        protection = loop.protection
        self._scale = scale_of(controller)
        self._commanded = commanded(controller, name)
        self._switched = switched(controller, name)
        self._current = current_of(controller)
        self._share = AS_DUE
        self._current_status = 0
        self._silent_ticks = 0
        self._lost_ticks = round((protection.master_lost_after_s or 0) * 100)
        self._waiting = [_order(Command.DISABLE), _order(Command.ENABLE)] * self._switched
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
        self._gains_now: tuple[float, ...] = (4.0, 0.02, 0.0)

    def inputs(self, course: list[Stretch]) -> NDArray[Any]:
        for stretch in course:
            begin = len(self._rows)
            if stretch.acknowledge and self._switched and not self._waiting:
                self._waiting = [_order(Command.DISABLE), _order(Command.ENABLE)]
            getattr(self, f"_{stretch.kind}")(stretch)
            if stretch.acknowledge or stretch.kind.startswith("tune"):
                status, _, *others = self._rows[begin]
                self._rows[begin] = (status, 1, *others)
        return np.array(self._rows, INPUT)

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
        others = self._current_status, self._share, self._silent_ticks
        self._rows.append((status, 0, raw, self._setpoint_c, *self._command, *others))
        self._command = NO_COMMAND

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
            left_k = self._scale.celsius(goal) - self._scale.celsius(self._raw)
            far = self._scale.moved(self._raw, fastest_k if left_k > 0 else -fastest_k)
            before = self._raw
            self._good(goal if abs(left_k) <= fastest_k or far == before else far)
            if self._raw == before:
                return  # as far as codes go

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

    def _order(self, stretch: Stretch) -> None:
        """Any command, also one that must be refused."""
        self._command = ORDERS[stretch.value % len(ORDERS)]
        self._hold(stretch)

    def _order_switched(self, stretch: Stretch) -> None:
        self._command = SWITCHED_ORDERS[stretch.value % len(SWITCHED_ORDERS)]
        self._zigzag(stretch)

    def _switch(self, stretch: Stretch) -> None:
        """Off and on, or only one of them, or on twice."""
        orders = [_order(Command.DISABLE), _order(Command.ENABLE), _order(Command.ENABLE)]
        self._waiting = orders[stretch.value % 3 :][: 1 + stretch.value // 3 % 3]
        self._zigzag(stretch)

    def _by_percent(self, stretch: Stretch) -> None:
        """By hand with a duty given before and after, and back."""
        self._command = (Command.PERCENT, abs(stretch.value) / 1.9, NO_GAINS)
        self._hold(stretch)
        self._command = (Command.MANUAL, abs(stretch.value) / 2.0, NO_GAINS)
        self._hold(stretch)
        self._command = (Command.PERCENT, abs(stretch.value) / 2.1, NO_GAINS)
        self._hold(stretch)
        self._command = _order(Command.AUTOMATIC)
        self._hold(stretch)

    def _silence(self, stretch: Stretch) -> None:
        self._silent_ticks = max(0, self._lost_ticks + stretch.nudge)
        self._zigzag(stretch._replace(steps=1 + stretch.steps // 4))
        self._silent_ticks = 0

    def _load(self, stretch: Stretch) -> None:
        """The heater draws another share of what is due, at the setpoint or below it."""
        if stretch.value % 3 == 0:
            self._ramp_to(self._setpoint_c - 5)
        self._share = SHARES[stretch.value % len(SHARES)]
        self._zigzag(stretch)
        self._share = AS_DUE

    def _leak(self, stretch: Stretch) -> None:
        """About as little current as is called none, far above the setpoint or anywhere."""
        if stretch.value % 3:
            self._ramp_to(self._setpoint_c + 6)
        self._draw(IDLE_CODES + stretch.nudge, stretch)

    def _over(self, stretch: Stretch) -> None:
        assert self._current is not None
        self._draw(round(self._current.over_a * CODES_PER_AMPERE) - 2 + stretch.nudge, stretch)

    def _draw(self, codes: int, stretch: Stretch) -> None:
        self._share = -1 - codes
        self._zigzag(stretch)
        self._share = AS_DUE

    def _no_scan(self, stretch: Stretch) -> None:
        self._current_status = 4
        self._load(stretch)
        self._current_status = 0

    def _off_and_on(self, stretch: Stretch) -> None:
        """Begin anew near the setpoint, on either side of it."""
        goal_c = self._setpoint_c
        self._set(0.0)
        if self._switched:
            self._command = _order(Command.DISABLE)
            self._waiting = [_order(Command.ENABLE)]
        self._good(self._last_good)
        if stretch.value % 3 == 0:
            self._command = (Command.GAINS, 0.0, (abs(stretch.value) / 8, 0.125, 2.0))
        self._ramp_to(goal_c + stretch.value / 32)
        self._set(goal_c)
        self._zigzag(stretch)

    def _manual(self, stretch: Stretch) -> None:
        self._ramp_to(self._setpoint_c + stretch.value % 11 - 5)
        self._command = (Command.MANUAL, max(0.0, abs(stretch.value) / 1.9 - 3), NO_GAINS)
        self._zigzag(stretch)
        self._set(self._setpoint_c)
        self._hold(stretch)

    def _gains(self, stretch: Stretch) -> None:
        random = Random(stretch.value)  # noqa: S311
        gains = [random.choice((0.0, 1e6, *(random.uniform(0, 30),) * 6)) for _ in range(3)]
        if stretch.value % 2:  # one of them alone
            kept = stretch.value // 2 % 3
            gains = [gains[n] if n == kept else old for n, old in enumerate(self._gains_now)]
        self._gains_now = tuple(gains)
        self._command = (Command.GAINS, 0.0, self._gains_now)
        self._drift(stretch)

    def _tune(self, stretch: Stretch) -> None:
        """A machine that a relay makes swing, whatever the relay does."""
        random = Random(stretch.value)  # noqa: S311
        cycles, slowest = 3 + stretch.value % 2, random.choice((5, 40))
        self._set(self._setpoints_c[stretch.steps % len(self._setpoints_c)])
        self._hold(stretch._replace(steps=1))
        goal_c, height_k = self._setpoint_c, random.uniform(1, 6)
        self._command = (Command.TUNE, goal_c, (cycles, 0.0, 0.0))
        self._ramp_to(goal_c - random.uniform(0, 30))
        if stretch.value % 3:
            self._ramp_to(goal_c - 21)
        self._ramp_to(goal_c + height_k - 0.5)
        for _ in range(cycles + 3 if stretch.kind == "tune" else stretch.steps % cycles):
            self._ramp_to(goal_c + random.uniform(height_k, 6), 0, random.uniform(1, 3))
            if stretch.value % 5 == 0:
                self._missed(1 + stretch.value % 3)
            self._ramp_to(goal_c - random.uniform(height_k, 7), 0, random.uniform(1, slowest))

    def _tune_in_part(self, stretch: Stretch) -> None:
        self._tune(stretch)
        if stretch.value % 2:
            self._command = (Command.STOP_TUNING, 0.0, NO_GAINS)
            self._hold(stretch)

    def _tune_by_hand(self, stretch: Stretch) -> None:
        """A tuning and the readings it gets: from the target in K, or how many are missing."""
        self._set(TUNED_C)
        self._hold(stretch)
        self._ramp_to(TUNED_C - 15)
        self._command = (Command.TUNE, TUNED_C, (3.0, 0.0, 0.0))
        for kind, value in TUNINGS[stretch.value]:
            if kind in ("to", "slowly"):
                self._ramp_to(TUNED_C + value, 0, 6.0 if kind == "slowly" else 1.0)
            elif kind == "at":
                self._good(self._scale.code(TUNED_C + value))
            else:
                for number in range(int(value)):
                    self._one_more(kind, number)
        self._use_gains(stretch)

    def _one_more(self, kind: str, number: int) -> None:
        if kind == "gone":
            self._missed(1)
        else:
            self._good(self._last_good + (kind == "wobble") * (-1) ** number)

    def _use_gains(self, stretch: Stretch) -> None:
        """What was found is in use, and outlives other gains."""
        for command in (Command.SET, Command.GAINS, Command.RELOAD):
            self._command = (command, TUNED_C, (3.5, 0.25, 1.5))
            self._hold(stretch._replace(steps=2))


def _order(command: Command) -> tuple[Any, ...]:
    return (command, 0.0, NO_GAINS)


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
