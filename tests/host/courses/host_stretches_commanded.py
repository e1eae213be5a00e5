"""Stretches of a course in which a host or a master commands, or is lost; and of a current. And
those in which a program moves the setpoint, and people give it orders."""

from random import Random
from typing import Any

import numpy as np
from courses.host_reference import Restored, Way
from courses.host_stretches import ALL_CLOSED, AS_DUE, NO_GAINS, NOT_WARM, Stretch, Walk

from heatwright.sim.host.firmware import INPUT, Command
from heatwright.sim.reference.algorithms.pid import limits_of
from heatwright.sim.reference.programs.state import IDLE, JUMP, PAUSE, RESUME, SKIP, START, STOP
from heatwright.spec import Controller, Current, Pid, facts_of
from heatwright.spec.adjusted import Number

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
"""In the sum of four codes at 0.2 V/A and 5 V, as host_specs has it; 0 A is at -2 codes."""
IDLE_CODES = 10  # the sum that is just three steps of the ADC


SWITCHED_ORDERS: tuple[tuple[Any, ...], ...] = (
    *ORDERS,
    *((each, 0.0, NO_GAINS) for each in (Command.ENABLE, Command.DISABLE, Command.AUTOMATIC)),
    *((Command.PERCENT, value, NO_GAINS) for value in (0.0, 100.0, 100.5, -0.5, float("nan"))),
)
CRITICAL_C = (5.0, 4.9375, 85.0, 85.0625, float("nan"), 40.0, 33.0)
"""About the lowest setpoint and the machine's own limit, as host_specs has them."""
SHARES = (300, 150, 75, 60, 50, 49, 30, 10, 0, 1000)  # measured currents, in % of what is due
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
        self._switched = facts_of(controller, name).switched
        self._current = current_of(controller)
        self._keyed = facts_of(controller, name).keyed_numbers
        self._lost_ticks = round((loop.protection.master_lost_after_s or 0) * 100)
        self._widest = limits_of(loop.algorithm) if isinstance(loop.algorithm, Pid) else ()
        self._go_on()

    def _go_on(self) -> None:
        if self._switched and not self._waiting:
            self._waiting = [order(Command.DISABLE), order(Command.ENABLE)]

    def _zigzag_while(
        self, stretch: Stretch, *, status: int = 0, share: int = AS_DUE, silent_ticks: int = 0
    ) -> None:
        """Zigzag with another status or share of the current, or without the master."""
        self._others = (status, share, silent_ticks)
        self._zigzag(stretch)
        self._others = (0, AS_DUE, 0)

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
        for command, part in (
            (Command.PERCENT, 1.9), (Command.MANUAL, 2.0), (Command.PERCENT, 2.1)
        ):  # fmt: skip
            self._command = (command, abs(stretch.value) / part, NO_GAINS)
            self._hold(stretch)
        self._command = order(Command.AUTOMATIC)
        self._hold(stretch)

    def _silence(self, stretch: Stretch) -> None:
        silent_ticks = max(0, self._lost_ticks + stretch.nudge)
        shorter = stretch._replace(steps=1 + stretch.steps // 4)
        self._zigzag_while(shorter, silent_ticks=silent_ticks)

    def _load(self, stretch: Stretch) -> None:
        """The heater draws another share of what is due, at the setpoint or below it."""
        if stretch.value % 3 == 0:
            self._ramp_to(self._setpoint_c - 5 - stretch.steps % 5)
        self._zigzag_while(stretch, share=SHARES[stretch.value % len(SHARES)])

    def _leak(self, stretch: Stretch) -> None:
        """About as little current as is called none, far above the setpoint or anywhere."""
        if stretch.value % 3:
            self._ramp_to(self._setpoint_c + 6)
        self._zigzag_while(stretch, share=-1 - (IDLE_CODES + stretch.nudge))

    def _over(self, stretch: Stretch) -> None:
        assert self._current is not None
        codes = round(self._current.over_a * CODES_PER_AMPERE) - 2 + stretch.nudge
        self._zigzag_while(stretch, share=-1 - codes)

    def _no_scan(self, stretch: Stretch) -> None:
        share = SHARES[stretch.value % len(SHARES)]
        self._zigzag_while(stretch, status=SCAN_LOST, share=share)

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


PROGRAM_KINDS = (
    "start", "start", "follow", "follow", "arrive", "arrive", "lag", "order_program", "interrupt",
    "leap", "skip", "order_late",
)  # fmt: skip
FIRING_KINDS = (*PROGRAM_KINDS, *PROGRAM_KINDS, "miss", "drift", "off_and_on", "switch", "manual")
"""What a course is made of that is little else than programs."""

COLD_C = 4.0  # below the lowest setpoint; the other way it goes to above the highest
PLACES = 9  # one more than there are; the eighth is empty
PROGRAM_ORDERS = (STOP, PAUSE, START, RESUME, SKIP, JUMP)


class ProgrammedWalk(CommandedWalk):
    """Knows by a reference model of its own where the setpoint is."""

    def __init__(self, controller: Controller, restored: Restored | None = None) -> None:
        super().__init__(controller)
        assert controller.programs is not None
        back = controller.programs.hold_back
        back_k = 5.0 if back is None else back.within_k
        reached_k = controller.programs.reached_within_k
        self._lags_k = (0.0, 0.25, 0.0, back_k, -back_k, reached_k, -reached_k, 2 * back_k)
        self._near_k = (reached_k, -reached_k, 0.0, reached_k / 2)
        self._resume_k = controller.programs.after_power_loss.resume_within_k
        self._way = Way(controller, restored)
        self._before_c = 30.0 if restored is None else float(restored.program.before_c)
        if restored is not None and restored.program.state != IDLE:
            self._waiting = []
        fault_code = 0 if restored is None else restored.fault_code
        self._last: dict[str, Any] = {"program.state": IDLE, "fault.code": fault_code}

    def _add(self, row: tuple[Any, ...]) -> None:
        super()._add(row)
        named = dict(zip(INPUT.names or (), (*row, ALL_CLOSED, NOT_WARM), strict=True))
        self._last = self._way.take(len(self._rows) - 1, named)
        self._setpoint_c = float(self._last["setpoint_c"])

    def _go_on(self) -> None:
        """Switch on only where no program is disturbed."""
        if not self._rows or self._last["fault.code"]:
            super()._go_on()

    def _give(self, order: int, argument: int = 0) -> None:
        self._ordered = (order, argument)
        self._good(self._last_good)

    def _near(self, goal_c: float, nudge: int = 0) -> None:
        """Take one step towards a temperature."""
        self._good(self._towards(self._scale.code(goal_c) + nudge, self._fastest_k))

    def _come_back(self, stretch: Stretch) -> None:
        """After a reset: find a temperature that it may go on from, or not, or wait for one."""
        places_k = (0.0, self._resume_k, -self._resume_k, 20.0, 0.25, -0.25)
        off_k = places_k[stretch.value % len(places_k)]
        if stretch.value % 4 == 0:
            self._ordered = (stretch.value // 4 % 8, 1)
        for _ in range(stretch.value % 3):
            self._missed(1)
        self._raw = self._scale.code(self._before_c + off_k) + (stretch.value // 5 % 3 - 1)
        self._good(self._raw)
        for _ in range(stretch.steps):
            self._near(self._setpoint_c)

    def _start(self, stretch: Stretch) -> None:
        """Start a program, perhaps after another is stopped, from where it is or near 30 °C."""
        self._acknowledges = self._acknowledges or bool(self._last["fault.code"])
        if stretch.value % 2 and self._last["program.state"] != IDLE:
            self._give(STOP)
        if stretch.value % 3:
            self._ramp_to(30 + stretch.value / 10)
        elif stretch.value % 5 == 0:
            self._ramp_to(COLD_C if stretch.value % 2 else self._setpoints_c[1] + 7.0)
        self._give(START, abs(stretch.value) % (PLACES + 1))
        self._follow(stretch)

    def _follow(self, stretch: Stretch) -> None:
        """Be where the setpoint is, or behind it by what holds it back or not."""
        lag_k = self._lags_k[stretch.value % len(self._lags_k)]
        for number in range(2 * stretch.steps):
            self._near(self._setpoint_c - lag_k, stretch.nudge + (number % 8 == 7))

    def _arrive(self, stretch: Stretch) -> None:
        """Get to where the target counts as reached, or a step short of it."""
        off_k = self._near_k[stretch.value % len(self._near_k)]
        for _ in range(2 * stretch.steps):
            self._near(float(self._last.get("program.to_c", 30.0)) + off_k, stretch.nudge)

    def _lag(self, stretch: Stretch) -> None:
        """Stand still for long, below or above."""
        lag_k = self._lags_k[stretch.value % len(self._lags_k)]
        self._ramp_to(self._setpoint_c - lag_k, stretch.nudge)
        for _ in range(2 * stretch.steps):
            self._good(self._raw + (-1) ** len(self._rows))

    def _order_program(self, stretch: Stretch) -> None:
        """Any order, with any number, twice in a row."""
        for place in range(2):
            value = abs(stretch.value) + 7 * place
            self._give(value % (len(PROGRAM_ORDERS) + 2), value // 8 % PLACES)
        self._zigzag(stretch)

    def _interrupt(self, stretch: Stretch) -> None:
        """Pause, drift away, and return to just where that counts."""
        self._give(PAUSE)
        if stretch.value % 3:
            self._drift(stretch)
        self._give(RESUME)
        if stretch.value % 5 == 0:
            self._missed(1)
        off_k = self._near_k[stretch.value % len(self._near_k)]
        for _ in range(stretch.steps + 6):
            self._near(self._setpoint_c + off_k, stretch.nudge)

    def _leap(self, stretch: Stretch) -> None:
        if stretch.value % 4 == 0:
            self._give(PAUSE)
        self._give(JUMP, abs(stretch.value) % 8)
        if stretch.value % 4 == 0:
            self._hold(stretch)
            self._give(RESUME)
        self._follow(stretch)

    def _skip(self, stretch: Stretch) -> None:
        self._give(SKIP)
        self._follow(stretch)

    def _order_late(self, stretch: Stretch) -> None:
        """Orders while there is no reading; a later one may replace an earlier one."""
        number, value = len(PROGRAM_ORDERS), stretch.value
        if value % 2:
            self._give(JUMP, 2)
        self._ordered = PROGRAM_ORDERS[value % number], abs(value) % PLACES
        for _ in range(1 + stretch.steps // 4):
            self._missed(1)
        if value % 3:
            self._ordered = PROGRAM_ORDERS[value // 8 % number], abs(value) // 5 % PLACES
            self._missed(4)
        self._zigzag(stretch)
