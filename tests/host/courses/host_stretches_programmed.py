"""Stretches of a course in which a program moves the setpoint, and people give it orders."""

from typing import Any

from courses.host_reference import Restored, Way
from courses.host_stretches import ALL_CLOSED, NOT_WARM, Stretch
from courses.host_stretches_commanded import CommandedWalk

from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference.programs.state import IDLE, JUMP, PAUSE, RESUME, SKIP, START, STOP
from heatwright.spec import Controller

PROGRAM_KINDS = (
    "start", "start", "follow", "follow", "arrive", "arrive", "lag", "order_program", "interrupt",
    "leap", "skip", "order_late",
)  # fmt: skip
FIRING_KINDS = (*PROGRAM_KINDS, *PROGRAM_KINDS, "miss", "drift", "off_and_on", "switch", "manual")
"""Of a course that is little else than programs."""

COLD_C = 4.0
"""Below the lowest setpoint; the other way it goes to above the highest."""
PLACES = 9
"""One more than there are; the eighth is empty."""
ORDERS = (STOP, PAUSE, START, RESUME, SKIP, JUMP)


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
        goal = self._scale.code(goal_c) + nudge
        left_k = self._scale.celsius(goal) - self._scale.celsius(self._raw)
        far = self._scale.moved(self._raw, self._fastest_k if left_k > 0 else -self._fastest_k)
        self._good(goal if abs(left_k) <= self._fastest_k else far)

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
            self._give(value % (len(ORDERS) + 2), value // 8 % PLACES)
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
        if stretch.value % 2:
            self._give(JUMP, 2)
        self._ordered = (ORDERS[stretch.value % len(ORDERS)], abs(stretch.value) % PLACES)
        for _ in range(1 + stretch.steps // 4):
            self._missed(1)
        if stretch.value % 3:
            self._ordered = (
                ORDERS[stretch.value // 8 % len(ORDERS)],
                abs(stretch.value) // 5 % PLACES,
            )
            self._missed(4)
        self._zigzag(stretch)
