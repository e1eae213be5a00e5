"""What a master writes to the reference device (docs/control.md, "Switched loops")."""

from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.operator import gains_of
from heatwright.sim.reference.switched import SwitchedOperator
from heatwright.spec import Controller, Write


class Master:
    """A master whose writes arrive at once, and who is never silent."""

    def __init__(
        self, controller: Controller, name: str, operator: SwitchedOperator, reference: Reference
    ) -> None:
        """Serve the only loop."""
        self._name = name
        self._operator = operator
        self._reference = reference
        self._gains = gains_of(controller.loops[name].algorithm)

    def write(self, name: str, value: float | bool) -> None:
        """Write a value by its name in a scenario; what is refused changes nothing.

        Raises:
            KeyError: there is nothing of that name.

        """
        written = Write(name, value)
        if written.loop not in ("", self._name):
            raise KeyError(name)
        if written.loop:
            self._of_loop(written.what, value)
        elif written.what == "acknowledge":
            self._operator.acknowledge()
        elif written.what == "restore" and self._gains is not None:
            self._operator.restore_gains(self._gains)
        elif written.what != "store":
            raise KeyError(name)

    def _of_loop(self, what: str, value: float | bool) -> None:
        operator = self._operator
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
