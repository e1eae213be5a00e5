"""The reference model's way through a course, and how the host's way is compared with it."""

from collections.abc import Container
from math import nan
from typing import Any, NamedTuple

import numpy as np
from host_commands import Commands
from numpy.typing import NDArray

from heatwright.sim.host.firmware import READY, STATE, Run
from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.current import IdealSensor
from heatwright.sim.reference.held import has_minimum
from heatwright.sim.reference.inputs import Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.output import pwm_period
from heatwright.sim.reference.program_state import ProgramState
from heatwright.spec import Controller, DigitalOutput

TICK_US = 10_000
TRIPPED_BY, TRIPPED_C = 6, 21.5
SLACK = 0.001
"""Of counts: the reference has shares of a time, which do not add up to the last bit."""


class Restored(NamedTuple):
    """What is there after a reset, where that is not what the specification says."""

    program: ProgramState
    setpoint_c: Single
    gains: Gains | None
    critical_c: float
    """Of loops where it is adjustable."""
    fault_code: int
    fault_c: Single
    fault_s: int


class Expected(NamedTuple):
    states: NDArray[Any]
    heater_counts: NDArray[np.float64]
    """Not numbers where the output decides by itself: nothing is expected then."""
    ticks: int
    cooler_ticks: int


class Way:
    """A reference model that does what the rows of a course say, one after the other."""

    def __init__(self, controller: Controller, restored: Restored | None = None) -> None:
        ((name, self._loop),) = controller.loops.items()
        self._reference = Reference(controller, name)
        self._commands = Commands(controller, name, self._reference)
        self._course = course_of(controller, self._loop.heater)
        output = controller.outputs[self._loop.heater]
        pwm = output.kind == "pwm"
        self._whole = pwm_period(controller, self._loop.heater).counts if pwm else 1
        self._period_us = round(self._loop.period_s * 1e6)
        self._time_s = 0
        self._record: Record | None = None
        self._takes_turn = False
        self._holds = isinstance(output, DigitalOutput) and has_minimum(output)
        self._holds = self._holds or controller.safety.relay is not None
        lost_s = self._loop.protection.master_lost_after_s
        self._silence_ticks = None if lost_s is None else round(lost_s * 100)
        self._current = getattr(output, "current", None)
        if self._current is not None:
            sensor = controller.sensors[self._current.sensor]
            self._sensor = IdealSensor(sensor, controller.board)
            self._due_a = output.power_w / output.supply_v / 100
        if restored is not None:
            self._reference.restore(restored.fault_code, restored.fault_c)
            self._time_s = restored.fault_s
            self._commands.restore(*restored[:4])

    def take(self, number: int, row: Any) -> dict[str, Any]:
        """Do the step of a row, and return the state after it."""
        self.give(number, row)
        return dict(zip(self.members, self.step(number, row), strict=True))

    def fill_currents(self, inputs: NDArray[Any]) -> None:
        """Make currents of what the rows say: per cent of what is due, or -1 - codes."""
        taken = 0
        for number, row in enumerate(inputs):
            self.give(number, row)
            share = int(row["current_raw"])
            amperes = float(self._reference.duty_percent) * self._due_a * share / 100
            raw = -1 - share if share < 0 else self._sensor.read(amperes)[1]
            taken = row["current_raw"] = taken if row["current_status"] else raw
            self.step(number, row)

    def expected(
        self, inputs: NDArray[Any], kind: np.dtype[Any], tripped: Container[int] = ()
    ) -> Expected:
        """What `Host.run` should give: the state after each step, the heater's counts before it.

        `tripped`: the steps before which a fault is latched and acknowledged at once.
        """
        rows: list[tuple[Any, ...]] = []
        counts, total = [], 0.0
        for number, row in enumerate(inputs):
            if number in tripped:
                self._trip_and_acknowledge(number)
            self.give(number, row)
            if self._takes_turn:  # from the cooler: whatever is due, the first tick is off
                self._course.advance((number - 1) * self._period_us + TICK_US)
            on_us = self._course.advance(number * self._period_us)
            total += nan if self._holds else on_us * self._whole / TICK_US
            counts.append(total)
            rows.append(self.step(number, row))
        states = np.zeros(len(rows), kind)
        for member, column in zip(self.members, zip(*rows, strict=True), strict=True):
            states[member] = column
        period_ticks = self._period_us // TICK_US
        cooled = int(states["cooling"][:-1].sum()) if self._loop.cooler else 0
        return Expected(states, np.array(counts), len(inputs) * period_ticks, cooled * period_ticks)

    @property
    def members(self) -> list[str]:
        told = [STATE if self._commands.switched else READY] * self._commands.commanded
        return [*(name for name, _ in self._reference.members), "fault.time_s", *told]

    def _trip_and_acknowledge(self, number: int) -> None:
        """Between two steps, faster than either sees it."""
        if not self._reference.fault_code:
            self._reference.restore(TRIPPED_BY, Single(TRIPPED_C))
            self._time_s = number * self._period_us // 1_000_000
        self._commands.acknowledge()
        if self._commands.commanded:
            self._course.apply(0)

    def give(self, number: int, row: Any) -> tuple[bool, bool]:
        """Acknowledge and command, at once after the last step; a stop does not wait for one.

        Return whether the command and the order are taken.
        """
        if row["acknowledge"]:
            self._commands.acknowledge()
        code = self._reference.fault_code
        taken = self._commands.give(row)
        if self._reference.fault_code != code:
            self._time_s = number * self._period_us // 1_000_000
            self._course.apply(0)
        if self._commands.has_closed:
            self._course.apply(0)
        return taken

    def tells(self) -> bool | None:
        """Whether the loop says now that it is ready, or on, if it is switched."""
        return self._commands.tells(self._record)

    def step(self, number: int, row: Any) -> tuple[Any, ...]:
        reference, commands = self._reference, self._commands
        code, cooled = reference.fault_code, reference.cooling
        reading = int(row["reading_status"]), int(row["reading_raw"])
        record = reference.step(*reading, commands.setpoint_c(row), orders=self._orders(row))
        self._record = record
        self._takes_turn = bool(cooled and not reference.cooling)
        commands.after_step()
        self._course.apply(reference.output.counts)
        if record["fault.code"] != code:
            self._time_s = (number + 1) * self._period_us // 1_000_000
        return (*record.values(), self._time_s, *self._told(record))

    def _orders(self, row: Any) -> Orders:
        silence = self._silence_ticks
        return self._commands.orders._replace(
            current_raw=int(row["current_raw"]),
            master_lost=silence is not None and int(row["silent_ticks"]) >= silence,
        )

    def _told(self, record: Record) -> list[int | bool]:
        if not self._commands.commanded:
            return []
        tell = self._commands.state if self._commands.switched else self._commands.is_ready
        return [tell(record)]


def first_difference(found: Run, wanted: Expected) -> str:
    """Name the first step after which the two differ, by whatever bit; empty if none."""
    counts = found.heater_counts, wanted.heater_counts
    beside = np.abs(counts[0] - counts[1]) > SLACK
    if found.states.tobytes() == wanted.states.tobytes() and not beside.any():
        return ""  # quickly, for it is so nearly always
    off = {"heater counts": (beside, *counts)}
    for member in found.states.dtype.names or ():
        ours, theirs = found.states[member].copy(), wanted.states[member].copy()
        off[member] = (_bits(ours) != _bits(theirs), ours, theirs)
    rows = {name: int(which.argmax()) for name, (which, *_) in off.items() if which.any()}
    if not rows:
        return ""
    name = min(rows, key=lambda each: rows[each])
    row, (_, ours, theirs) = rows[name], off[name]
    return f"after step {row + 1}, {name}: host {ours[row]!r}, reference {theirs[row]!r}"


def _bits(values: NDArray[Any]) -> NDArray[Any]:
    return values.view(f"u{values.dtype.itemsize}")
