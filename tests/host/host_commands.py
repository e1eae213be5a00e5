"""Commands of a course, given to the reference model's operator; what they keep and when ready."""

from typing import Any

from heatwright.sim.host import Command
from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.autotune import DONE
from heatwright.sim.reference.inputs import NO_ORDERS, Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.operator import Operator
from heatwright.spec import Controller, commanded

READY_WITHIN_K = 1.0
"""Of a loop whose specification does not say it."""


class Commands:
    def __init__(self, controller: Controller, name: str, reference: Reference) -> None:
        loop = controller.loops[name]
        self.commanded = commanded(controller, name)
        self._reference = reference
        self._operator = Operator(controller, name, reference)
        self._kept = self._defaults = self._operator.gains
        within_k = loop.ready_within_k
        self._within_k = Single(READY_WITHIN_K if within_k is None else within_k)

    @property
    def orders(self) -> Orders:
        return self._operator.orders if self.commanded else NO_ORDERS

    def setpoint_c(self, row: Any) -> Single:
        return self._operator.setpoint_c if self.commanded else Single(row["setpoint_c"])

    def acknowledge(self) -> None:
        self._operator.acknowledge()

    def give(self, row: Any) -> None:
        """Do what a row of a course commands; where it does not apply, nothing."""
        command, value = Command(row["command"]), float(row["value"])
        if not self.commanded:
            return
        if command == Command.SET:
            self._operator.set(value)
        elif command == Command.EMERGENCY:
            self._reference.stop()
        elif self._operator.gains is not None:
            self._tuned(command, value, [float(each) for each in row["gains"]])

    def _tuned(self, command: Command, value: float, gains: list[float]) -> None:
        operator = self._operator
        match command:
            case Command.MANUAL:
                operator.set_manual(value)
            case Command.TUNE:
                operator.tune(value, int(gains[0]))
            case Command.STOP_TUNING:
                operator.stop_tuning()
            case Command.GAINS:
                operator.set_gains(*gains)
            case Command.KEEP:
                self._kept = operator.gains
            case Command.RELOAD:
                operator.gains = self._kept
            case Command.DEFAULTS:
                operator.gains = self._defaults

    def after_step(self) -> None:
        """What a tuning found is kept."""
        before: Gains | None = self._operator.gains
        self._operator.after_step()
        tuner = self._reference.steering.tuner
        if tuner is not None and tuner.result == DONE and self._operator.gains is not before:
            self._kept = self._operator.gains

    def is_ready(self, record: Record) -> bool:
        """Whether the loop is ready, by docs/control.md, "Commands"."""
        setpoint_c = Single(record["setpoint_c"])
        automatic = record.get("mode", 0) == 0 and setpoint_c != 0
        well = record["fault.code"] == 0 and record["reading_status"] == 0
        off_by_k = abs(setpoint_c - Single(record["temperature_c"]))
        return bool(automatic and well and off_by_k <= self._within_k)
