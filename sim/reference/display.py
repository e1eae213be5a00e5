"""What a touch display's buttons do to the reference device (docs/nextion.md).

Of all commands those that steer: what only asks for a page, a name or a list changes nothing here.
"""

import re
from collections.abc import Callable

from heatwright.sim.reference.operator import Operator
from heatwright.sim.reference.programmed import ProgrammedOperator
from heatwright.sim.reference.switched import SwitchedOperator

_COMMAND = re.compile(r"#\s*(\d{1,2})\s*([^#;]*);")


class Display:
    """A display that nothing is answered."""

    def __init__(self, operator: Operator) -> None:
        """Serve the loop of an operator.

        Raises:
            TypeError: it is of a loop that cannot be switched.

        """
        if not isinstance(operator, SwitchedOperator):
            message = "A display needs a loop that is switched"
            raise TypeError(message)
        self._operator = operator
        self._does: dict[int, Callable[[float], object]] = {
            2: lambda on: operator.switch(on=bool(on)),
            3: operator.set,
            4: self._heat,
            5: lambda kp: operator.set_gains(kp, None, None),
            6: lambda ki: operator.set_gains(None, ki, None),
            16: lambda _: operator.acknowledge(),
            19: lambda kd: operator.set_gains(None, None, kd),
            20: operator.set_critical,
        }
        if isinstance(operator, ProgrammedOperator):
            self._does |= _orders(operator)

    def send(self, text: str) -> None:
        """Do what the bytes say, command by command.

        Raises:
            ValueError: there is no command in them.

        """
        found = _COMMAND.findall(text)
        if not found:
            message = f"{text!r} is no command of a display: write one such as #8 1;"
            raise ValueError(message)
        for command, data in found:
            does = self._does.get(int(command))
            if does is not None:
                does(float(data or 0))

    def _heat(self, percent: float) -> None:
        self._operator.set_manual(percent)


def _orders(operator: ProgrammedOperator) -> dict[int, Callable[[float], object]]:
    """Return the commands to a program."""
    return {
        8: lambda number: operator.order("start", int(number)),
        9: lambda runs: operator.order("resume" if runs else "pause"),
        10: lambda segment: operator.order("jump", int(segment)),
        17: lambda _: operator.order("stop"),
        18: lambda _: operator.order("skip"),
    }
