"""Stretches of a course in which a host or a master commands, or is lost; and of a current."""

from random import Random
from typing import Any

import numpy as np
from courses.host_stretches import AS_DUE, NO_GAINS, Stretch, Walk

from heatwright.sim.host.firmware import Command
from heatwright.sim.reference.algorithms.pid import limits_of
from heatwright.spec import Controller, Current, Pid
from heatwright.spec.adjusted import Number, numbers_of
from heatwright.spec.commands import switched

ORDERS: tuple[tuple[Any, ...], ...] = (
    *((Command.SET, value, NO_GAINS) for value in (0.0, -0.0, -1.0, 1e4, float("nan"), 30.0)),
    *((Command.MANUAL, value, NO_GAINS) for value in (0.0, 100.0, 100.5, -0.5, float("nan"))),
    *((Command.TUNE, value, (cycles, 0, 0)) for value, cycles in ((50, 0), (60, 255), (0, 5))),
    *((Command.TUNE, value, (5, 0, 0)) for value in (float("nan"), 1e4)),
    *((each, 0.0, NO_GAINS) for each in (
        Command.STOP_TUNING, Command.KEEP, Command.RELOAD, Command.DEFAULTS, Command.EMERGENCY,
    )),
)  # fmt: skip


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


def order(command: Command) -> tuple[Any, ...]:
    return (command, 0.0, NO_GAINS)


CODES_PER_AMPERE = 4096 / 25
"""Of the sum of four codes at 0.2 V/A and 5 V, as host_specs has it; 0 A is at -2 codes."""
IDLE_CODES = 10
"""The sum that is just three steps of the ADC."""


SWITCHED_ORDERS: tuple[tuple[Any, ...], ...] = (
    *ORDERS,
    *((each, 0.0, NO_GAINS) for each in (Command.ENABLE, Command.DISABLE, Command.AUTOMATIC)),
    *((Command.PERCENT, value, NO_GAINS) for value in (0.0, 100.0, 100.5, -0.5, float("nan"))),
)
CRITICAL_C = (5.0, 4.9375, 85.0, 85.0625, float("nan"), 40.0, 33.0)
"""About the lowest setpoint and the machine's own limit, as host_specs has them."""
SHARES = (300, 150, 75, 60, 50, 49, 30, 10, 0, 1000)
"""Of the current that is due, %."""
SCAN_LOST = 4


def current_of(controller: Controller) -> Current | None:
    ((_, loop),) = controller.loops.items()
    return getattr(controller.outputs[loop.heater], "current", None)


def _about(number: Number) -> list[float]:
    """Values of a number that count, and some beyond its ends, which do not."""
    low, high = np.float32(number.minimum), np.float32(number.maximum)
    inside = [low, high, (low + high) / 2, low + np.float32(number.step)]
    up, down = np.float32(np.inf), np.float32(-np.inf)
    beyond = [np.nextafter(low, down), np.nextafter(high, up), np.nan, up, down, -high]
    return [float(each) for each in (*inside * 3, *beyond)]


class CommandedWalk(Walk):
    _gains_now: tuple[float, ...] = (4.0, 0.02, 0.0)

    def __init__(self, controller: Controller) -> None:
        super().__init__(controller)
        ((name, loop),) = controller.loops.items()
        self._switched = switched(controller, name)
        self._current = current_of(controller)
        self._keyed = numbers_of(controller, name)
        self._lost_ticks = round((loop.protection.master_lost_after_s or 0) * 100)
        self._widest = limits_of(loop.algorithm) if isinstance(loop.algorithm, Pid) else ()
        self._go_on()

    def _go_on(self) -> None:
        if self._switched and not self._waiting:
            self._waiting = [order(Command.DISABLE), order(Command.ENABLE)]

    def _set_others(self, status: int = 0, share: int = AS_DUE, silent_ticks: int = 0) -> None:
        self._others = (status, share, silent_ticks)

    def _order_switched(self, stretch: Stretch) -> None:
        self._command = SWITCHED_ORDERS[stretch.value % len(SWITCHED_ORDERS)]
        self._zigzag(stretch)

    def _switch(self, stretch: Stretch) -> None:
        """Off and on, or only one of them, or on twice."""
        orders = [order(Command.DISABLE), order(Command.ENABLE), order(Command.ENABLE)]
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
        self._command = order(Command.AUTOMATIC)
        self._hold(stretch)

    def _silence(self, stretch: Stretch) -> None:
        self._set_others(silent_ticks=max(0, self._lost_ticks + stretch.nudge))
        self._zigzag(stretch._replace(steps=1 + stretch.steps // 4))
        self._set_others()

    def _load(self, stretch: Stretch) -> None:
        """The heater draws another share of what is due, at the setpoint or below it."""
        if stretch.value % 3 == 0:
            self._ramp_to(self._setpoint_c - 5 - stretch.steps % 5)
        self._set_others(share=SHARES[stretch.value % len(SHARES)])
        self._zigzag(stretch)
        self._set_others()

    def _leak(self, stretch: Stretch) -> None:
        """About as little current as is called none, far above the setpoint or anywhere."""
        if stretch.value % 3:
            self._ramp_to(self._setpoint_c + 6)
        self._draw(IDLE_CODES + stretch.nudge, stretch)

    def _over(self, stretch: Stretch) -> None:
        assert self._current is not None
        self._draw(round(self._current.over_a * CODES_PER_AMPERE) - 2 + stretch.nudge, stretch)

    def _draw(self, codes: int, stretch: Stretch) -> None:
        self._set_others(share=-1 - codes)
        self._zigzag(stretch)
        self._set_others()

    def _no_scan(self, stretch: Stretch) -> None:
        self._set_others(status=SCAN_LOST, share=SHARES[stretch.value % len(SHARES)])
        self._zigzag(stretch)
        self._set_others()

    def _critical(self, stretch: Stretch) -> None:
        """Move the critical temperature, at times to just above this one."""
        chosen_c = CRITICAL_C[stretch.value % len(CRITICAL_C)]
        if stretch.value % 2:
            chosen_c = self._scale.celsius(self._raw) + stretch.nudge / 16
        self._command = (Command.MAXIMUM, chosen_c, NO_GAINS)
        self._zigzag(stretch)
        if stretch.value % 4:
            self._command = (Command.MAXIMUM, 85.0, NO_GAINS)
        self._hold(stretch)

    def _numbers(self, stretch: Stretch) -> None:
        """Have keys set numbers, now and then to what no key sets, and go where they tell."""
        random = Random(stretch.value)  # noqa: S311
        chosen = [random.choice(_about(each)) for each in self._keyed]
        self._command = (Command.NUMBERS, 0.0, tuple([*chosen, 0.0, 0.0][:3]))
        away = self._offsets_k
        if self._keyed[0].kind.key == "hysteresis" and 0 <= chosen[0] < 10:
            self._offsets_k = [chosen[0], -chosen[0], *away]
        self._reach(stretch._replace(value=abs(stretch.value) | 1))
        self._offsets_k = away
        self._zigzag(stretch)

    def _order(self, stretch: Stretch) -> None:
        """Any command, also one that must be refused."""
        self._command = ORDERS[stretch.value % len(ORDERS)]
        self._hold(stretch)

    def _off_and_on(self, stretch: Stretch) -> None:
        """Begin anew near the setpoint, on either side of it."""
        goal_c = self._setpoint_c
        self._set(0.0)
        if self._switched:
            self._command = order(Command.DISABLE)
            self._waiting = [order(Command.ENABLE)]
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

    def _limits(self, stretch: Stretch) -> None:
        """Limits of integral and output: the spec's own, narrower ones, and some that cannot be;
        then so cold that the loop asks for all that it may."""
        random = Random(stretch.value)  # noqa: S311
        least, most, full = self._widest
        limits = [least, most, full]
        if stretch.value % 3:
            limits = sorted(random.uniform(least, full) for _ in range(3))
            limits[1] = min(limits[1], most)
        if stretch.value % 4 == 3:
            limits[random.randrange(3)] = random.choice((-1.0, 0.0, full + 1, float("nan"), full))
        self._command = (Command.LIMITS, 0.0, tuple(limits))
        if stretch.value % 5:
            self._ramp_to(self._setpoint_c - 25 + stretch.value % 20)
        self._drift(stretch._replace(value=stretch.value % 60 - 20))

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
