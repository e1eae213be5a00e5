"""Derive the program's state before the first step after a reset from that step's log."""

import numpy as np

from heatwright.sim.reference.numbers import Single, Value
from heatwright.sim.reference.programs.program import without_energy_of
from heatwright.sim.reference.programs.state import (
    IDLE,
    INTERRUPTED,
    MEMBERS,
    NOTHING,
    PAUSED,
    RESTORING,
    RESUME,
    RETURNING,
    RUNNING,
    ProgramState,
)


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
