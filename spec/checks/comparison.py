"""Rows of a comparison: each is a controller of its own and must pass the checks of one."""

from __future__ import annotations

from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.commands import switched
from heatwright.spec.controller import ComparisonRow, Controller
from heatwright.spec.derived import with_derived
from heatwright.spec.problems import Path


def row_controller(controller: Controller, row: ComparisonRow) -> Controller:
    """Put a row's setpoint, algorithm and output in the place of the first loop's own.

    The row's setpoint becomes the initial one, and the loop is on, so that a run needs no operator.
    """
    name, loop = next(iter(controller.loops.items()))
    setpoint = loop.setpoint.model_copy(update={"initial_c": row.setpoint_c})
    changed = loop.model_copy(
        update={
            "algorithm": row.algorithm,
            "setpoint": setpoint,
            "autotune": loop.autotune if row.algorithm.kind == "pid" else None,
            "starts": "enabled" if switched(controller, name) else None,
        }
    )
    outputs = dict(controller.outputs)
    if row.output is not None:
        outputs[loop.heater] = row.output
    row_of = controller.model_copy(
        update={
            "loops": ReadOnlyDict({**controller.loops, name: changed}),
            "outputs": ReadOnlyDict(outputs),
            "comparison": (),
        }
    )
    return with_derived(row_of)


def row_path(controller: Controller, index: int, path: Path) -> Path:
    """Find the entry of a row that stands for an entry of its controller; else the row itself."""
    name, loop = next(iter(controller.loops.items()))
    row: Path = ("comparison", index)
    if path[:3] == ("loops", name, "algorithm"):
        return (*row, *path[2:])
    if path[:3] == ("loops", name, "setpoint"):
        return (*row, "setpoint")
    if path[:2] == ("outputs", loop.heater) and controller.comparison[index].output is not None:
        return (*row, "output", *path[2:])
    return row
