"""All control steps of a log at once: each is repeated from the state that the log has before it.

If each step, repeated so, ends in the state that the log has after it, then the model that runs
through all steps, one after the other, has every one of these states, too.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.arrays.masks import afresh
from heatwright.sim.arrays.modules import on_arrays
from heatwright.sim.reference import Reference
from heatwright.sim.reference.inputs import Orders
from heatwright.sim.reference.sensors.reading import Average
from heatwright.sim.tape import commands_in, numbers_in
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller
from heatwright.spec.registry import brought


def are_repeated(controller: Controller, loop: str, log: StepLog, since: Reference) -> bool:
    """Return whether the model repeats each row of a log, the first one left out, bit for bit.

    Return False also if the steps cannot be repeated side by side, and for a sensor or an algorithm
    from outside, whose model may have a state that the log does not have. log -- rows between which
    only readings and commands are new, as `Tape.usual` finds them; since -- the model after the
    first row, which has the copy of a program; it `is_shown`.
    """
    after = log[1:]
    if _is_from_outside(controller, loop):
        return False
    try:
        with afresh():
            model = on_arrays("heatwright.sim.reference.loop").Reference(controller, loop)
            if since.program:
                part = on_arrays("heatwright.sim.reference.programs.copies").Part
                copy = tuple(part(*each) for each in since.program.copy)
                model.program.load(since.program.now.number, copy)
            resume(model, log, since, slice(-1))
            found = model.stepped(
                numbers_in(after, "reading_status"),
                numbers_in(after, "reading_raw"),
                numbers_in(after, "setpoint_c"),
                orders=Orders(**commands_in(after)),
            )
    except Exception:
        return False
    return all(
        np.array_equal(bits(np.full(len(after), value, width)), bits(after[name]))
        for (name, width), value in zip(since.members, found, strict=True)
    )


def resume(model: Reference, log: StepLog, since: Reference, rows: int | slice) -> None:
    """Let a model continue from its state after these rows of a log.

    model -- the model, or the translated one with a lane for each row; since -- the model after the
    first row of the log.
    """
    model.resume([_at(rows, numbers_in(log, name)) for name, _ in since.members])
    for prefix, first in since.averages.items():
        window, turns = _windows(log, prefix, first)
        average = model.averages[prefix]
        average.window, average.turn = [each[rows] for each in window], _at(rows, turns)
        average.is_empty = False


def _windows(log: StepLog, prefix: str, first: Average) -> tuple[list[NDArray[Any]], NDArray[Any]]:
    """Return an average's readings and turn; first -- the average after the first row."""
    places = np.arange(size := len(first.window))
    valid = log[f"{prefix}reading_status"] == 0
    valid[0] = False
    count = np.cumsum(valid)
    readings = numbers_in(log, f"{prefix}reading_c")[valid]
    series = np.concatenate((np.roll(np.array(first.window), -first.turn), readings))
    turns = (first.turn + count) % size
    return [series[count + (place - turns) % size] for place in places], turns


def _is_from_outside(controller: Controller, loop: str) -> bool:
    sensors = {each.kind for each in controller.sensors.values()}
    own = sensors.isdisjoint(brought("sensor"))
    return not own or controller.loops[loop].algorithm.kind in brought("algorithm")


def _at(rows: int | slice, column: NDArray[Any]) -> Any:
    """Return a column's values in these rows as an array; for a single row, one number."""
    found = column[rows]
    return int(found) if isinstance(found, np.integer) else found


def bits(values: NDArray[Any]) -> NDArray[Any]:
    """Return the bits of numbers, as unsigned integers: NaN and −0.0 are compared by them."""
    return np.ascontiguousarray(values).view(f"u{values.dtype.itemsize}")
