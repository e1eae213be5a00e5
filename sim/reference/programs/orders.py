"""Commands to a loop with programs (docs/control.md, "Commands to the program")."""

from collections.abc import Callable

from heatwright.sim.reference.inputs import AUTOMATIC
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.programs.copies import Copy, copy_of
from heatwright.sim.reference.programs.program import ProgramRun
from heatwright.sim.reference.programs.state import (
    IDLE,
    INTERRUPTED,
    JUMP,
    NO_ORDER,
    PAUSE,
    PAUSED,
    RESTORING,
    RESUME,
    RETURNING,
    RUNNING,
    SKIP,
    START,
    STOP,
)
from heatwright.spec import Controller
from heatwright.spec.scenario.program_orders import Order

ORDERS: dict[Order, int] = {
    "start": START, "pause": PAUSE, "resume": RESUME, "skip": SKIP, "jump": JUMP, "stop": STOP,
}  # fmt: skip


class ProgrammedOperator(SwitchedOperator):
    """The commands to a loop and its programs."""

    def __init__(self, controller: Controller, name: str, reference: Reference) -> None:
        """Take the programs of the spec. Raises ValueError: the spec has none for this loop."""
        super().__init__(controller, name, reference)
        if reference.program is None or controller.programs is None:
            raise ValueError(f"Loop {name} has no programs")
        self._run: ProgramRun = reference.program
        self._keeps = controller.programs.on_fault == "pause"
        stored = controller.programs.stored
        self.copies: dict[int, Copy] = {
            number: copy_of(program) for number, program in enumerate(stored, 1)
        }
        """The programs by their numbers; a missing one is empty."""

    @property
    def state(self) -> int:
        """The program's state."""
        return self._run.now.state

    def order(self, order: Order, number: int = 0) -> bool:
        """Give a command; return whether that is allowed."""
        code = ORDERS[order]
        waits = self._program[0]
        if waits == STOP:
            return code == STOP  # repeated
        if waits == PAUSE and code not in (STOP, PAUSE):
            return False
        if not self._may_order(code, number):
            if code == START and self.state == IDLE and not self._reference.fault_code:
                self._program = NO_ORDER  # no such program: a waiting command is forgotten
            return False
        if code == START:
            self._run.load(number, self.copies[number])
        self._program = (code, number)
        return True

    def set(self, setpoint_c: float) -> bool:
        """Set the setpoint that holds without a program."""
        return not self._run.is_active and super().set(setpoint_c)

    def enable(self) -> bool:
        """Switch on, to hold the setpoint."""
        return not self._run.is_active and super().enable()

    def disable(self) -> None:
        """Switch off, and stop the program that is active or about to start."""
        self.order("stop")
        if self.state == IDLE:
            super().disable()

    def set_manual(self, percent: float | None) -> bool:
        """Set the manual duty."""
        return not self._run.is_active and super().set_manual(percent)

    def tune(self, target_c: float, cycles: int | None) -> bool:
        """Start a tuning."""
        return not self._run.is_active and super().tune(target_c, cycles)

    def acknowledge(self) -> None:
        """Acknowledge a fault; drop the waiting command, but no STOP of an interrupted program."""
        if self._reference.fault_code and not (self._keeps and self._program[0] == STOP):
            self._program = NO_ORDER
        super().acknowledge()

    def after_step(self) -> None:
        """Take over the switch and the setpoint that the program left at its end."""
        if not self._reference.order_waits:
            self._program = NO_ORDER
        if self._run.handed_over is not None:
            self._off_is_due = False
            self._mode = AUTOMATIC
            self._enabled, held_c = self._run.handed_over
            self.setpoint_c = self.setpoint_c if held_c is None else held_c
        super().after_step()
        self._was_on = self._was_on or self._run.is_active

    def _may_order(self, code: int, number: int) -> bool:
        if code == STOP:
            return self._run.is_active or self._program[0] != NO_ORDER[0]
        if self._reference.fault_code:
            return False
        if code == PAUSE:
            return self.state in (RUNNING, RETURNING) or self._program[0] in (START, RESUME)
        fits: dict[int, Callable[[], bool]] = {
            START: lambda: self.state == IDLE and number in self.copies,
            RESUME: lambda: self.state in (PAUSED, INTERRUPTED),
            SKIP: lambda: self.state == RUNNING,
            JUMP: lambda: (
                self.state not in (IDLE, RESTORING) and 1 <= number <= self._run.now.segments + 1
            ),
        }
        return fits[code]()
