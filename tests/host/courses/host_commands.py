"""Commands of a course, given to the reference model's operator; what they keep and when ready."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from heatwright.sim.host import Command
from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.algorithms.autotune import DONE
from heatwright.sim.reference.inputs import NO_ORDERS, Gains, Orders
from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.programs.orders import ORDERS, ProgrammedOperator
from heatwright.sim.reference.programs.state import IDLE, ProgramState
from heatwright.spec import Controller, ThreePosition, facts_of

READY_WITHIN_K = 1.0  # default for a loop whose specification does not say it


_SWITCHING: dict[Command, Callable[[SwitchedOperator, float], object]] = {
    Command.ENABLE: lambda operator, _: operator.enable(),
    Command.DISABLE: lambda operator, _: operator.disable(),
    Command.PERCENT: lambda operator, percent: (
        operator.gains is None or operator.set_manual_percent(percent)
    ),
    Command.AUTOMATIC: lambda operator, _: operator.steer_by_hand(on=False),
}


_ORDERS = {code: name for name, code in ORDERS.items()}
SHARED = (Command.KEEP, Command.RELOAD, Command.DEFAULTS)
"""Commands that are about the gains of all loops."""
CLOSING = ("stop", "pause")
NUMBERED = ("start", "jump")


class Commands:
    def __init__(self, controller: Controller, name: str, reference: Reference) -> None:
        loop = controller.loops[name]
        self.commanded = facts_of(controller, name).commanded
        self._reference = reference
        self.switched = facts_of(controller, name).switched
        self._adjustable = loop.protection.maximum_adjustable
        self._operator = _operator(controller, name, reference)
        self._closes = False
        self._kept = self._defaults = (self._operator.gains, self._operator.limits)
        within_k = loop.ready_within_k
        if self.switched and isinstance(loop.algorithm, ThreePosition):
            within_k = loop.algorithm.dead_band_k
        self._within_k = Single(READY_WITHIN_K if within_k is None else within_k)

    def restore(
        self, program: ProgramState, setpoint_c: Single, gains: Gains | None, critical_c: float
    ) -> None:
        operator, run = self._operator, self._reference.program
        assert isinstance(operator, ProgrammedOperator)
        assert run is not None
        operator.setpoint_c = setpoint_c
        operator.gains, self._kept = gains, (gains, operator.limits)
        operator.set_critical(critical_c)
        run.restore(replace(program))
        if program.state != IDLE:
            SwitchedOperator.disable(operator)  # without an order to the program
            run.load(program.number, operator.copies[program.number])

    @property
    def orders(self) -> Orders:
        return self._operator.orders if self.commanded else NO_ORDERS

    def setpoint_c(self, row: Any) -> Single:
        return self._operator.setpoint_c if self.commanded else Single(row["setpoint_c"])

    def acknowledge(self) -> None:
        self._operator.acknowledge()

    def give(self, row: Any) -> tuple[bool, bool]:
        """Do what a row of a course commands, and say whether command and order are taken; where
        one does not apply, nothing is done, and that is not refused."""
        command, value = Command(row["command"]), float(row["value"])
        if not self.commanded:
            return True, True
        self._closes = False
        taken = self._command(command, value, row)
        given = True
        if isinstance(self._operator, ProgrammedOperator) and row["order"] in _ORDERS:
            order = _ORDERS[row["order"]]
            argument = int(row["argument"]) if order in NUMBERED else 0
            given = self._operator.order(order, argument)
            self._closes = self._closes or (given and order in CLOSING)
        return taken is not False, given

    def _command(self, command: Command, value: float, row: Any) -> object:
        operator = self._operator
        if command == Command.SET:
            return operator.set(value)
        if command == Command.EMERGENCY:
            return None if self.switched else self._reference.stop()
        if command == Command.MAXIMUM:
            return not self._adjustable or operator.set_critical(value)
        if isinstance(operator, SwitchedOperator) and command in _SWITCHING:
            self._closes = command == Command.DISABLE
            return _SWITCHING[command](operator, value)
        if command == Command.NUMBERS:
            numbers = zip(operator.numbers, row["gains"], strict=False)  # it has as many or more
            operator.numbers = {field: Single(value) for field, value in numbers}
        if operator.gains is None:
            return None
        return self._tuned(command, value, [float(each) for each in row["gains"]])

    def _tuned(self, command: Command, value: float, gains: list[float]) -> object:
        operator = self._operator
        match command:
            case Command.MANUAL:
                return operator.set_manual(value)
            case Command.TUNE:
                return self._reference.steering.tuner is None or operator.tune(value, int(gains[0]))
            case Command.STOP_TUNING:
                operator.stop_tuning()
            case Command.GAINS:
                return operator.set_gains(*gains)
            case Command.LIMITS:
                return operator.limits is None or operator.set_limits(*gains)
            case Command.KEEP:
                self._kept = operator.gains, operator.limits
            case Command.RELOAD:
                operator.gains, operator.limits = self._kept
            case Command.DEFAULTS:
                operator.gains, operator.limits = self._defaults
        return None

    def share(self, row: Any) -> None:
        """Do what a command to another loop does to all."""
        if row["command"] in SHARED and self.is_tunable:
            self._tuned(Command(row["command"]), 0.0, [])

    @property
    def is_tunable(self) -> bool:
        return self._operator.gains is not None

    def see_fault(self) -> None:
        self._operator.see_fault()

    @property
    def has_closed(self) -> bool:
        """Whether a loop is off at once, before the step that takes it over."""
        active = isinstance(self._operator, ProgrammedOperator) and self._operator.state != IDLE
        return self._closes or (self.switched and self._operator.is_off and not active)

    def after_step(self) -> None:
        before: Gains | None = self._operator.gains
        self._operator.after_step()
        tuner = self._reference.steering.tuner
        if tuner is not None and tuner.result == DONE and self._operator.gains is not before:
            self._kept = self._operator.gains, self._kept[1]

    def is_ready(self, record: Record) -> bool:
        """Whether the loop is ready, by docs/control.md, "Commands"."""
        automatic = record.get("mode", 0) == 0 and record["setpoint_c"] != 0
        return bool(automatic and self._is_near(record))

    def tells(self, record: Record | None) -> bool | None:
        """What it says between two steps, by the record of the last: is it ready, is it on? While
        a program decides nobody asks."""
        operator = self._operator
        if isinstance(operator, ProgrammedOperator) and operator.state != IDLE:
            return None
        if self.switched:
            return not operator.is_off
        if not record or not operator.is_automatic or self._reference.fault_code:
            return False
        return operator.setpoint_c == record["setpoint_c"] and self.is_ready(record)

    def state(self, record: Record) -> int:
        """What a master reads of the loop, by docs/control.md, "Switched loops"."""
        works = bool(record["enabled"] and record["fault.code"] == 0)
        bits = (
            works,
            record["duty_percent"] > 0,
            record.get("cooling", 0),
            works and self._is_near(record),
        )
        return sum(bool(bit) << place for place, bit in enumerate(bits))

    def _is_near(self, record: Record) -> bool:
        well = record["fault.code"] == 0 and record["reading_status"] == 0
        off_by_k = abs(Single(record["setpoint_c"]) - Single(record["temperature_c"]))
        return bool(well and off_by_k <= self._within_k)


def _operator(controller: Controller, name: str, reference: Reference) -> Operator:
    if facts_of(controller, name).programmed:
        return ProgrammedOperator(controller, name, reference)
    if facts_of(controller, name).switched:
        return SwitchedOperator(controller, name, reference)
    return Operator(controller, name, reference)
