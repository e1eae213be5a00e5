"""A master's writes to the reference device (docs/control.md, "Switched loops")."""

from collections.abc import Callable, Mapping

from heatwright.sim.reference.algorithms.pid import gains_of
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.spec import Controller, Write


class Master:
    """A master whose writes act at once, and which is never silent."""

    def __init__(
        self,
        controller: Controller,
        operators: Mapping[str, SwitchedOperator],
        acknowledge: Callable[[], None],
    ) -> None:
        """Serve operators' loops, by name; `acknowledge` acknowledges a fault of any loop."""
        self._operators = operators
        self._acknowledge = acknowledge
        self._gains = {name: gains_of(controller.loops[name].algorithm) for name in operators}

    def write(self, name: str, value: float | bool) -> None:
        """Write a value by its name in a scenario; a refused write changes nothing.

        Raises KeyError: there is no value of that name.
        """
        written = Write(name, value)
        if written.loop:
            _steer(self._operators[written.loop], written.what, value)
        elif written.what == "acknowledge":
            self._acknowledge()
        elif written.what == "restore" and any(self._gains.values()):
            for loop, gains in self._gains.items():
                if gains is not None:
                    self._operators[loop].gains = gains
        elif written.what != "store":
            raise KeyError(name)


def _steer(operator: SwitchedOperator, what: str, value: float | bool) -> None:
    if what == "enabled":
        operator.switch(on=bool(value))
    elif what == "setpoint":
        operator.set(value)
    elif what == "manual_duty":
        operator.set_manual_percent(value)
    elif what == "manual":
        operator.steer_by_hand(on=bool(value))
    elif what == "tune":
        operator.switch_tuning(on=bool(value))
    elif what in ("kp", "ki", "kd"):
        operator.set_gains(*(value if gain == what else None for gain in ("kp", "ki", "kd")))
    else:
        raise KeyError(what)
