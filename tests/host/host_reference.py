"""The reference model's way through a course, and how the host's way is compared with it."""

from typing import Any, NamedTuple

import numpy as np
from host_commands import Commands
from numpy.typing import NDArray

from heatwright.sim.host.firmware import READY, Run
from heatwright.sim.reference import Reference
from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.output import pwm_period
from heatwright.spec import Controller

TICK_US = 10_000
SLACK = 0.001
"""Of counts: the reference has shares of a time, which do not add up to the last bit."""


class Expected(NamedTuple):
    states: NDArray[Any]
    heater_counts: NDArray[np.float64]
    ticks: int


def expected(controller: Controller, inputs: NDArray[Any], kind: np.dtype[Any]) -> Expected:
    """What `Host.run` should give: the state after each step and the heater's counts before it."""
    return _Way(controller).expected(inputs, kind)


class _Way:
    def __init__(self, controller: Controller) -> None:
        ((name, self._loop),) = controller.loops.items()
        self._reference = Reference(controller, name)
        self._commands = Commands(controller, name, self._reference)
        self._course = course_of(controller, self._loop.heater)
        output = controller.outputs[self._loop.heater]
        pwm = output.kind == "pwm"
        self._whole = pwm_period(controller, self._loop.heater).counts if pwm else 1
        self._period_us = round(self._loop.period_s * 1e6)
        self._time_s = 0

    def expected(self, inputs: NDArray[Any], kind: np.dtype[Any]) -> Expected:
        rows: list[tuple[Any, ...]] = []
        counts, total = [], 0.0
        for number, row in enumerate(inputs):
            self._give(number, row)
            on_us = self._course.advance(number * self._period_us)
            total += on_us * self._whole / TICK_US
            counts.append(total)
            rows.append(self._step(number, row))
        states = np.zeros(len(rows), kind)
        for member, column in zip(self._members, zip(*rows, strict=True), strict=True):
            states[member] = column
        return Expected(states, np.array(counts), len(inputs) * self._period_us // TICK_US)

    @property
    def _members(self) -> list[str]:
        ready = [READY] if self._commands.commanded else []
        return [*(name for name, _ in self._reference.members), "fault.time_s", *ready]

    def _give(self, number: int, row: Any) -> None:
        """Acknowledge and command, at once after the last step; a stop does not wait for one."""
        if row["acknowledge"]:
            self._commands.acknowledge()
        code = self._reference.fault_code
        self._commands.give(row)
        if self._reference.fault_code != code:
            self._time_s = number * self._period_us // 1_000_000
            self._course.apply(0)

    def _step(self, number: int, row: Any) -> tuple[Any, ...]:
        reference, commands = self._reference, self._commands
        code = reference.fault_code
        record = reference.step(
            int(row["reading_status"]),
            int(row["reading_raw"]),
            commands.setpoint_c(row),
            orders=commands.orders,
        )
        commands.after_step()
        self._course.apply(reference.output.counts)
        if record["fault.code"] != code:
            self._time_s = (number + 1) * self._period_us // 1_000_000
        ready = [commands.is_ready(record)] if commands.commanded else []
        return (*record.values(), self._time_s, *ready)


def first_difference(found: Run, wanted: Expected) -> str:
    """Name the first step after which the two differ, by whatever bit; empty if none."""
    if found.states.tobytes() == wanted.states.tobytes() and np.allclose(
        found.heater_counts, wanted.heater_counts, rtol=0, atol=SLACK
    ):
        return ""
    differences = []
    for member in wanted.states.dtype.names or ():
        ours, theirs = found.states[member].copy(), wanted.states[member].copy()
        rows = np.flatnonzero(_bits(ours) != _bits(theirs))
        if len(rows):
            row = int(rows[0])
            differences.append((row, member, ours[row], theirs[row]))
    rows = np.flatnonzero(np.abs(found.heater_counts - wanted.heater_counts) > SLACK)
    if len(rows):
        row = int(rows[0])
        counts = found.heater_counts[row], wanted.heater_counts[row]
        differences.append((row, "heater counts", *counts))
    if not differences:
        return ""
    row, member, ours, theirs = min(differences, key=lambda each: each[0])
    return f"after step {row + 1}, {member}: host {ours!r}, reference {theirs!r}"


def _bits(values: NDArray[Any]) -> NDArray[Any]:
    return values.view(f"u{values.dtype.itemsize}")
