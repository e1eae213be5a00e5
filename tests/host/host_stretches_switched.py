"""Stretches of a course in which a master switches, or is lost, and of a heater's current."""

from typing import Any

from host_stretches import AS_DUE, NO_GAINS, Stretch
from host_stretches_commanded import ORDERS, CommandedWalk, order

from heatwright.sim.host.firmware import Command
from heatwright.spec import Controller, Current
from heatwright.spec.commands import switched

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


class SwitchedWalk(CommandedWalk):
    def __init__(self, controller: Controller) -> None:
        super().__init__(controller)
        ((name, loop),) = controller.loops.items()
        self._switched = switched(controller, name)
        self._current = current_of(controller)
        self._lost_ticks = round((loop.protection.master_lost_after_s or 0) * 100)
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
            self._ramp_to(self._setpoint_c - 5)
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
