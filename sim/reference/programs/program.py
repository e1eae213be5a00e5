"""The program that sets a loop's setpoint, step by step (docs/control.md, "Programs")."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from heatwright.sim.reference.inputs import AUTOMATIC, Orders
from heatwright.sim.reference.numbers import ZERO, Single, Value
from heatwright.sim.reference.programs.copies import Copy
from heatwright.sim.reference.programs.ramps import Way
from heatwright.sim.reference.programs.state import (
    FAILED,
    FINISHED,
    FOR_TARGET,
    IDLE,
    INTERRUPTED,
    JUMP,
    MEMBERS,
    NOTHING,
    PAUSE,
    PAUSED,
    RESTORING,
    RESUME,
    RETURNING,
    RUNNING,
    SKIP,
    START,
    STOP,
    STOPPED,
    TOO_FAR,
    ProgramState,
)
from heatwright.spec import Loop, Programs

PROGRAM_LAGS = 24

HALF, TENTHS = Single(0.5), Single(10)
LARGEST_SUM = 0xFFFF_FFFF


class HandedOver(NamedTuple):
    """The loop's state that a program leaves at its end."""

    enabled: int
    setpoint_c: Single | None
    """None: the commanded setpoint."""


class ProgramRun:
    """The program that runs, with its copy."""

    members = MEMBERS

    def __init__(self, programs: Programs, loop: Loop) -> None:
        after = programs.after_power_loss
        self._way = Way(programs, loop)
        self._number = 0
        self._reading_c = ZERO
        self._resumes_k = Single(after.resume_within_k) if after.resume_within_k else None
        self._else_pauses = after.otherwise == "pause"
        self._keeps = programs.on_fault == "pause"
        self._holds = programs.at_end == "hold"
        self._range_c = Single(loop.setpoint.minimum_c), Single(loop.setpoint.maximum_c)
        self.now = ProgramState()
        self.handed_over: HandedOver | None = None
        """The state that the program left, if it ended in this step."""

    @property
    def is_active(self) -> bool:
        """Whether a program controls the loop."""
        return self.now.state != IDLE

    @property
    def moves(self) -> bool:
        """Whether a program runs whose setpoint did not jump in this step."""
        return self.now.state == RUNNING and not self.now.leap

    @property
    def copy(self) -> Copy:
        """The program that runs, or ran last."""
        return self._way.copy

    def load(self, number: int, copy: Copy) -> None:
        """Load the copy of the program that starts next, or resumes."""
        self._number, self._way.copy = number, copy

    def restore(self, state: ProgramState) -> None:
        """Restore the state from a record, after a loss of power."""
        self.now = state

    def fail(self) -> None:
        """End or interrupt an active program because of a fault."""
        now = self.now
        if not self._keeps:
            if self.is_active:
                self._end(FAILED)
        elif now.state in (RUNNING, RETURNING, RESTORING):
            now.state = INTERRUPTED
            now.waiting = NOTHING
            now.waited = 0

    def step(
        self,
        order: tuple[int, int],
        temperature_c: Single | None,
        *,
        reading_c: Single,
        fault: bool,
        damaged: bool,
    ) -> tuple[int, bool]:
        """Run the program's part of a step.

        Return the code of a fault, 0 for none, and whether the command still waits. order -- the
        waiting command, and its argument; temperature_c -- the temperature for the control, None
        without a valid reading; reading_c -- the last single reading; fault -- whether a fault is
        latched; damaged -- whether this step finds the memory damaged (rule 29).
        """
        now = self.now
        now.leap = now.order = now.argument = 0
        self._reading_c = reading_c
        now.rate_k_per_s = ZERO
        self.handed_over = None
        if damaged:
            if self.is_active:
                self._end(FAILED)
            return 0, False
        if fault:
            self.fail()
            if self._keeps and order[0] == STOP:
                now.order, now.argument = order
                self._obeyed(temperature_c)
            return 0, False
        waits = not self._may_take(order[0], temperature_c)
        if not waits:
            now.order, now.argument = order
        if now.state == RESTORING:
            self._restored(temperature_c)
            return 0, waits
        if self._obeyed(temperature_c):
            return 0, waits
        return self._go_on(temperature_c), waits

    def steered(self, orders: Orders, setpoint_c: Single) -> tuple[Orders, Single]:
        """Return the commands and the setpoint of a step, as the program sets them."""
        state = self.now.state
        if state in (RUNNING, RETURNING):
            return orders._replace(enabled=1, mode=AUTOMATIC), self.now.setpoint_c
        if state != IDLE:
            return orders._replace(enabled=0, mode=AUTOMATIC), self.now.setpoint_c
        if self.handed_over is None:
            return orders, setpoint_c
        enabled, held_c = self.handed_over
        orders = orders._replace(enabled=enabled, mode=AUTOMATIC)
        return orders, setpoint_c if held_c is None else held_c

    def count(self, duty_percent: Single, temperature_c: Single, *, fault: bool) -> None:
        """Count the energy of a step, and store its temperature if there is no fault."""
        if self.now.state in (RUNNING, RETURNING):
            self.now.energy = (self.now.energy + _permille(duty_percent)) & LARGEST_SUM
            if self._keeps and not fault:
                self.now.before_c = temperature_c

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return self.now.values()

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`; the copy is not among them."""
        self.now = ProgramState(*(next(values) for _ in self.members))

    def _may_take(self, order: int, temperature_c: Single | None) -> bool:
        if self.now.state == RESTORING:
            return order == STOP
        return order in (STOP, PAUSE) or temperature_c is not None

    # -- a loss of power -----------------------------------------------------------------------

    def _restored(self, temperature_c: Single | None) -> None:
        now = self.now
        if now.order == STOP:
            self._end(STOPPED)
        elif temperature_c is not None:
            self._go_on_if_near()

    def _go_on_if_near(self) -> None:
        now = self.now
        gone_k = abs(self._reading_c - now.before_c)
        if self._resumes_k is not None and gone_k <= self._resumes_k:
            now.state = RETURNING
            now.leap = 1
        elif self._else_pauses:
            now.state = PAUSED
        else:
            self._end(TOO_FAR)

    # -- commands --------------------------------------------------------------------------------

    def _obeyed(self, temperature_c: Single | None) -> bool:
        """Execute the command, if allowed; return whether the setpoint stays in this step."""
        now = self.now
        if now.order == STOP and self.is_active:
            self._end(STOPPED)
        elif now.order == PAUSE and now.state in (RUNNING, RETURNING):
            now.state = PAUSED
            now.waiting = NOTHING
        elif now.order == START and now.state == IDLE and temperature_c is not None:
            self._start(temperature_c)
            return True
        elif now.order == RESUME and now.state == PAUSED:
            now.state = RETURNING
            now.leap = 1
            return True
        elif now.order == RESUME and now.state == INTERRUPTED and temperature_c is not None:
            self._go_on_if_near()
            return True
        elif now.order == SKIP and now.state == RUNNING:
            self._begin(now.segment + 1)
            return True
        elif now.order == JUMP and self.is_active and 1 <= now.argument <= now.segments + 1:
            self._jump(now.argument)
            return True
        return False

    def _start(self, temperature_c: Single) -> None:
        now = self.now
        now.number, now.segments = self._number, len(self._way.copy)
        now.ended = now.clock = now.energy = 0
        if self._keeps:
            now.before_c = temperature_c
        now.first_c = now.setpoint_c = min(temperature_c, self._range_c[1])
        now.state = RUNNING
        now.leap = 1
        self._begin(1)

    def _jump(self, number: int) -> None:
        now = self.now
        now.setpoint_c = self._way.start_c(now, number)
        self._begin(min(number, now.segments))
        if number > now.segments:
            now.elapsed = now.length
        now.leap = 1
        if now.state == RUNNING:
            now.state = RETURNING

    # -- one step, and the end of a segment ----------------------------------------------------

    def _go_on(self, temperature_c: Single | None) -> int:
        now = self.now
        if now.state == RETURNING:
            self._return(temperature_c)
        elif now.state == RUNNING:
            now.clock += 1
            now.segment_clock += 1
            if temperature_c is not None:
                return self._go(temperature_c)
        return 0

    def _return(self, temperature_c: Single | None) -> None:
        now = self.now
        if temperature_c is not None and self._way.is_near(temperature_c, now.setpoint_c):
            now.state = RUNNING
            now.waiting = NOTHING
        else:
            now.waiting = FOR_TARGET

    def _go(self, temperature_c: Single) -> int:
        if self._way.go(self.now, temperature_c):
            self._finish()
        elif self._way.lags(self.now, temperature_c):
            return PROGRAM_LAGS
        return 0

    def _begin(self, number: int) -> None:
        if not self._way.begin(self.now, number):
            self._finish()

    def _finish(self) -> None:
        held_c = self.now.setpoint_c
        if self._holds and self._range_c[0] <= held_c <= self._range_c[1]:
            self._leave(FINISHED, HandedOver(1, held_c))
        else:
            self._end(FINISHED)

    def _end(self, why: int) -> None:
        self._leave(why, HandedOver(0, None))

    def _leave(self, why: int, left: HandedOver) -> None:
        self.now.state, self.now.waiting, self.now.ended = IDLE, NOTHING, why
        self.handed_over = left


def without_energy_of(duty_percent: Single, energy: int) -> int:
    """Return the energy sum before a step that was counted."""
    return (energy - _permille(duty_percent)) & LARGEST_SUM


def _permille(duty_percent: Single) -> int:
    return int(duty_percent * TENTHS + HALF)


def resumed(row: np.void) -> ProgramState:
    """Return the program as it was before the step.

    The step keeps what a record restores, except the state, the energy, and the reason of the end.
    The state before follows from the state after, as each has one possible origin after a reset.
    """
    found: dict[str, Value] = {name: _value(row, name, width) for name, width in MEMBERS}
    after, order = found["state"], found["order"]
    if after == RUNNING:
        return ProgramState()
    if after == IDLE and not found["segments"]:
        return ProgramState(number=found["number"], ended=found["ended"])
    found |= {"state": _state_before(after, order), "waiting": NOTHING, "ended": 0}
    before = ProgramState(**found)
    if after == RETURNING:
        before.energy = without_energy_of(Single(row["duty_percent"]), before.energy)
    return before


def _state_before(after: Value, order: Value) -> int:
    if after == INTERRUPTED or (order == RESUME and after in (IDLE, PAUSED)):
        return INTERRUPTED
    return PAUSED if after == PAUSED or order == RESUME else RESTORING


def _value(row: np.void, name: str, width: str) -> Value:
    value = row[f"program.{name}"]
    return Single(value) if width == "f4" else int(value)
