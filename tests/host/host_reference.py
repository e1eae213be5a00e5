"""The reference model's way through a course, and how the host's way is compared with it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.host.firmware import Run
from heatwright.sim.reference import Reference
from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.numbers import Single
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
    ((name, loop),) = controller.loops.items()
    reference = Reference(controller, name)
    course = course_of(controller, loop.heater)
    output = controller.outputs[loop.heater]
    whole = pwm_period(controller, loop.heater).counts if output.kind == "pwm" else 1
    period_us = round(loop.period_s * 1e6)
    rows: list[tuple[Any, ...]] = []
    counts, total, time_s, code = [], 0.0, 0, 0
    for number, row in enumerate(inputs):
        total += course.advance(number * period_us) * whole / TICK_US
        counts.append(total)
        record = reference.step(
            int(row["reading_status"]),
            int(row["reading_raw"]),
            Single(row["setpoint_c"]),
            acknowledge=bool(row["acknowledge"]),
        )
        course.apply(reference.output.counts)
        if record["fault.code"] not in (0, code) or (row["acknowledge"] and record["fault.code"]):
            time_s = (number + 1) * period_us // 1_000_000
        code = record["fault.code"]
        rows.append((*record.values(), time_s))
    members = [*reference.members, ("fault.time_s", "u4")]
    states = np.zeros(len(rows), kind)
    for member, column in zip(members, zip(*rows, strict=True), strict=True):
        states[member[0]] = column
    return Expected(states, np.array(counts), len(inputs) * period_us // TICK_US)


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
