"""Run the reference model with the inputs of each control step of a log."""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from heatwright.sim.arrays.steps import are_repeated, resume
from heatwright.sim.reference import Reference
from heatwright.sim.reference.loop import EMERGENCY_STOP, MASTER_LOST, STOPS, WATCHED_FAULTS
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.sim.reference.programs.copies import from_cell
from heatwright.sim.reference.programs.program import resumed
from heatwright.sim.reference.programs.state import START
from heatwright.sim.reference.protection.monitor import MONITOR_LIMIT
from heatwright.sim.tape import ACKNOWLEDGEMENTS, STARTS, Tape, count_in
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller

LOADED = "loaded"
"""Column of a log with the firmware's copy of the running program."""
FEWEST_AT_ONCE = 200
"""For fewer steps, arrays are slower than one step after the other."""


@dataclass(frozen=True)
class Restored:
    """A fault that was latched at the first step after a reset but did not trip in it."""

    row: int
    time_s: float
    fault_code: int


@dataclass(frozen=True)
class Latched:
    """A fault that was latched in a step or since the one before, by this loop or by another."""

    row: int
    time_s: float
    fault_code: int
    own: bool


class Player:
    """Runs the reference model row by row."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Create the reference model, in its state before the first step."""
        self._has_others = len(controller.loops) > 1
        self.latched: list[Latched] = []
        self._controller = controller
        self._loop = loop
        self._reference = Reference(controller, loop)
        self.members = list(self._reference.members)
        self.segments = 0
        """Number of series of steps between resets, so far."""
        self.restored: list[Restored] = []

    def play(self, log: StepLog) -> StepLog:
        """Return the reference model's state after each row."""
        self._log, self._tape = log, Tape(log)
        states = np.empty(len(log), self.members)
        done = 0
        for first, end in self._tape.usual():
            if end - first >= FEWEST_AT_ONCE:
                self._play_singly(states, done, first)
                done = self._play_until_shown(states, first, end)
                done = self._play_at_once(states, done, end) if done < end else end
        self._play_singly(states, done, len(log))
        return states

    def _play_singly(self, states: StepLog, first: int, end: int) -> None:
        self._orders = dict(zip(range(first, end), self._tape.orders(first, end), strict=True))
        for number in range(first, end):
            states[number] = self._played(number)

    def _play_until_shown(self, states: StepLog, first: int, end: int) -> int:
        while first < end and not self._reference.is_shown:
            block = first, min(first + FEWEST_AT_ONCE, end)
            self._play_singly(states, *block)
            first = block[1]
        return first

    def _play_at_once(self, states: StepLog, first: int, end: int) -> int:
        """Fill in the rows from `first` to `end` if no member differs; return the next row."""
        names = [name for name, _ in self.members]
        before, log = states[first - 1 : first], self._log[first - 1 : end]
        is_same = all(before[name].tobytes() == log[name][:1].tobytes() for name in names)
        if not is_same or not are_repeated(self._controller, self._loop, log, self._reference):
            return first
        for name in names:
            states[name][first:end] = log[name][1:]
        resume(self._reference, log, self._reference, -1)
        return end

    def _played(self, number: int) -> tuple[object, ...]:
        tape = self._tape
        if tape.begins[number]:
            return self._first_of_segment(number, self._log[number])
        if tape.acknowledged[number]:
            self._acknowledge(tape.acknowledged[number], self._passed_c(self._log[number]))
        code, starts = tape.fault_code[number], tape.started[number]
        lost = code == MASTER_LOST
        if self._reference.fault_code or not code:
            return self._fed(number, starts, lost=lost)
        return self._tripped(number, self._log[number], starts, lost=lost)

    def _tripped(self, number: int, row: np.void, starts: int, *, lost: bool) -> tuple[object, ...]:
        """Run a step after which a fault is latched, by this loop or by another.

        Another loop's fault comes before the step or, from a later loop in the tick, after it.
        """
        before = deepcopy(self._reference) if self._has_others else None
        values = self._fed(number, starts, lost=lost)
        code, temperature_c = int(row["fault.code"]), Single(row["fault.temperature_c"])
        own = self._reference.fault_code == code and (
            before is None or self._is_equal(values, row)  # several can trip the same rule at once
        )
        self.latched.append(Latched(number, float(row["time_s"]), code, own))
        if own or before is None:
            return values
        if code in WATCHED_FAULTS:  # by a later loop in the same tick, after this step
            self._reference = deepcopy(before)
            values = self._fed(number, starts, lost=False, watched=False)
        later = self._latched_after(values, row)
        if later is not None:
            return later
        self._reference = before
        before.restore(code, temperature_c)
        return self._fed(number, starts, lost=False)

    def _latched_after(self, values: tuple[object, ...], row: np.void) -> tuple[object, ...] | None:
        """Latch another loop's fault after a step; return None if the row contradicts that."""
        fault = {name: row[name] for name in ("fault.code", "fault.temperature_c")}
        later = tuple(
            fault.get(name, value) for (name, _), value in zip(self.members, values, strict=True)
        )
        if not self._has_others or not self._is_equal(later, row):
            return None
        self._reference.restore(int(row["fault.code"]), Single(row["fault.temperature_c"]))
        return later

    def _first_of_segment(self, number: int, row: np.void) -> tuple[object, ...]:
        self.segments += 1
        values = self._begun_with(0, number)
        code = int(row["fault.code"])
        tripped = self._reference.fault_code == code and (
            code not in (*WATCHED_FAULTS, MONITOR_LIMIT) or self._is_equal(values, row)
        )
        time_s = float(row["time_s"])
        if code and tripped:
            self.latched.append(Latched(number, time_s, code, own=True))
        if not code or tripped:
            return values
        restored = self._begun_with(code, number)
        if not self._is_equal(restored, row):
            later = self._latched_after(self._begun_with(0, number), row)
            if later is not None:
                self.latched.append(Latched(number, time_s, code, own=False))
                return later
            restored = self._begun_with(code, number)
        self.restored.append(Restored(number, time_s, code))
        return restored

    def _begun_with(self, code: int, number: int) -> tuple[object, ...]:
        """Run the first step after a reset; code -- the latched fault, 0: none or acknowledged.

        A fault that was acknowledged before this step is unknown here. Its acknowledgement, not the
        step, ended or interrupted the program that the reset had restored.
        """
        self._reference = Reference(self._controller, self._loop)
        row = self._log[number]
        acknowledged, fault_c = count_in(row, ACKNOWLEDGEMENTS), Single(row["fault.temperature_c"])
        if self._reference.program:
            self._reference.program.restore(resumed(row))
            self._load(row)
        self._acknowledge(acknowledged, fault_c)
        if code or not acknowledged:
            self._reference.restore(code, fault_c)
        return self._fed(number, count_in(row, STARTS), lost=False)

    def _passed_c(self, row: np.void) -> Single:
        """Return the temperature of a fault that came and was acknowledged since the step before.

        It is 0 for an emergency stop. For another loop's fault it is that of the row, °C, unless
        another rule has tripped since.
        """
        seen = self._has_others and not row["fault.code"]
        return Single(row["fault.temperature_c"]) if seen else ZERO

    def _acknowledge(self, times: int, passed_c: Single = ZERO) -> None:
        for _ in range(times):
            if not self._reference.fault_code:  # it came since the last step
                self._reference.restore(EMERGENCY_STOP, passed_c)
            self._reference.acknowledge()

    def _fed(
        self, number: int, starts: int, *, lost: bool, watched: bool = True
    ) -> tuple[object, ...]:
        tape, reference = self._tape, self._reference
        orders = self._orders[number]
        if not watched:
            orders = orders._replace(watch_fault=0)
        if tape.fault_code[number] in STOPS:
            reference.stop(tape.fault_code[number])
        if reference.program and orders.program[0] == START:
            self._load(self._log[number])
        if starts and (tuner := reference.steering.tuner):
            for _ in range(starts):
                tuner.start(int(self._log[number]["autotune.cycles"]))
        return reference.stepped(
            tape.status[number],
            tape.raw[number],
            tape.setpoint_c[number],
            orders=orders._replace(master_lost=True) if lost else orders,
        )

    def _is_equal(self, values: tuple[object, ...], row: np.void) -> bool:
        return all(
            row[name] == value for (name, _), value in zip(self.members, values, strict=True)
        )

    def _load(self, row: np.void) -> None:
        if program := self._reference.program:
            number = int(row["program.argument"] or row["program.number"])
            program.load(number, from_cell(row[LOADED]))
