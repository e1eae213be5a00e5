"""Figures of merit of a program's run: how close the temperature followed the setpoint.

Ramps and holds are judged separately. On a ramp the heater needs a while to reach the duty for the
slope, so the first minute is left out, also after a pause. The time in which the heater is at an
end of its range is left out, too: the machine then follows as fast as it can, and no controller
could do better.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL
from heatwright.sim.reference.programs.state import RUNNING
from heatwright.sim.trace import Series, StepLog
from heatwright.spec import Loop

FIRST_S = 60.0
"""The first part of a ramp; it is not judged."""
STEADY_SHARE = 1 / 3
"""The steady part of a hold is its last third."""


@dataclass(frozen=True)
class Firing:
    """Figures of merit of the programs of one run."""

    tracking_k: float | None
    """Largest distance of a reading from the setpoint on the ramps; None if there is nothing to
    judge."""
    overshoot_k: float
    """How far a hold's readings passed its setpoint, in the direction of the ramp before it."""
    steady: StepLog
    """The last third of the last hold, or of all steps if there is no hold."""
    rows: StepLog
    """All steps with a reading in which a program ran."""


def firing_of(log: StepLog, loop: Loop) -> Firing | None:
    """Evaluate the programs in a log; None if none ran."""
    if "program.state" not in (log.dtype.names or ()):
        return None
    runs = log["program.state"] == RUNNING
    kept = runs & (log["reading_status"] == 0)
    rows = log[kept]
    if not len(rows):
        return None
    parts = list(_parts(rows, np.cumsum(~runs)[kept]))
    ramps = [part for part in parts if part["program.kind"][0] in (OVER, RATE) and _direction(part)]
    ramps_k = [_errors_k(_judged(part, loop)) for part in ramps]
    judged = [float(np.abs(errors_k).max()) for errors_k in ramps_k if len(errors_k)]
    holds = [part for part in parts if part["program.kind"][0] in (HOLD, UNTIL)]
    last = holds[-1] if holds else rows
    return Firing(
        tracking_k=max(judged, default=None),
        overshoot_k=max((*_overshoots_k(parts), 0.0)),
        steady=last[-max(1, round(len(last) * STEADY_SHARE)) :],
        rows=rows,
    )


def _parts(rows: StepLog, pauses: NDArray[np.intp]) -> Iterator[StepLog]:
    """Split the steps where a segment begins, restarts, or resumes.

    `pauses` increases from one row to the next if the program did not run in between.
    """
    anew = np.diff(rows["program.segment_clock"].astype(np.int64)) <= 0
    other = np.diff(rows["program.segment"].astype(np.int64)) != 0
    yield from np.split(rows, np.flatnonzero(anew | other | (np.diff(pauses) != 0)) + 1)


def _direction(part: StepLog) -> float:
    """Return 1 for a ramp up, −1 for one down, 0 for none."""
    return float(np.sign(part["program.to_c"][0] - part["program.from_c"][0]))


def _judged(ramp: StepLog, loop: Loop) -> StepLog:
    duty_percent = ramp["duty_percent"]
    free = (duty_percent > 0) & (duty_percent < loop.algorithm.full_percent)
    clock = ramp["program.segment_clock"].astype(np.int64)
    begun = (clock - clock[0] + 1) * loop.period_s > FIRST_S
    judged: StepLog = ramp[free & begun]
    return judged


def _errors_k(part: StepLog) -> Series:
    errors: Series = part["temperature_c"].astype(float) - part["setpoint_c"].astype(float)
    return errors


def _overshoots_k(parts: list[StepLog]) -> Iterator[float]:
    """Yield how far each hold was passed, in the direction of the ramp before it, K."""
    direction = 0.0
    for part in parts:
        if part["program.kind"][0] in (OVER, RATE, FAST):
            direction = _direction(part)
        else:
            yield float((direction * _errors_k(part)).max())
