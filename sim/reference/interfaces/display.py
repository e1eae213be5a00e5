"""The effect of a touch display's commands on the reference device (docs/nextion.md)."""

import re
from collections.abc import Callable
from contextlib import suppress

from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.programs.orders import ProgrammedOperator
from heatwright.sim.reference.programs.points import Editor
from heatwright.spec import Controller

_ORDER = re.compile(r"#(\d{1,2}) ?([^#;]*);")
POINTS = 7

Does = dict[int, Callable[[float], object]]


class Display:
    """A touch display that gets no answers.

    Only commands that change something have an effect; requests for a page, a name or a list have
    none. A command that the firmware would refuse changes nothing.
    """

    def __init__(
        self, controller: Controller, operator: Operator, acknowledge: Callable[[], None]
    ) -> None:
        """Serve an operator's loop; `acknowledge` acknowledges a fault of any loop.

        Raises TypeError: the loop has no switch.
        """
        if not isinstance(operator, SwitchedOperator):
            raise TypeError("A display needs a loop that is switched")
        self._does: Does = {**_steering(operator), 16: lambda _: acknowledge()}
        self._programs: ProgrammedOperator | None = None
        if isinstance(operator, ProgrammedOperator):
            self._programs = operator
            self._editor = Editor(controller)
            self._shown = 1
            self._does |= {**_orders(operator), 13: self._show}

    def send(self, text: str) -> None:
        """Execute the commands of a text.

        Raises ValueError: there is no command in it.
        """
        found = _ORDER.findall(text)
        if not found:
            raise ValueError(f"{text!r} is no command of a display: write one such as #8 1;")
        for order, data in found:
            self._do(int(order), data)

    def _do(self, order: int, data: str) -> None:
        does = self._does.get(order)
        with suppress(ValueError):
            if order == POINTS and self._programs is not None:
                shown = self._programs.copies.get(self._shown, ())
                self._programs.copies[self._shown] = self._editor.edited(shown, data)
            elif does is not None:
                does(float(data or 0))

    def _show(self, number: float) -> None:
        self._shown = int(number)


def _steering(operator: SwitchedOperator) -> Does:
    """Return the commands that need no programs."""
    return {
        2: lambda on: _switch(operator, on=bool(on)),
        3: operator.set,
        4: operator.set_manual,
        5: lambda kp: operator.set_gains(kp, None, None),
        6: lambda ki: operator.set_gains(None, ki, None),
        19: lambda kd: operator.set_gains(None, None, kd),
        20: operator.set_critical,
    }


def _switch(operator: SwitchedOperator, *, on: bool) -> None:
    """Switch off, or on under automatic control."""
    if not on:
        operator.disable()
    elif operator.enable():
        operator.steer_by_hand(on=False)


def _orders(operator: ProgrammedOperator) -> Does:
    """Return the commands to a program."""
    return {
        8: lambda number: operator.order("start", int(number)),
        9: lambda runs: operator.order("resume" if runs else "pause"),
        10: lambda segment: operator.order("jump", int(segment) + 1),
        17: lambda _: operator.disable(),
        18: lambda _: operator.order("skip"),
    }
