"""Rows of a comparison: each makes a controller of its own, which must pass all checks."""

from heatwright.spec.adjusted import fixed
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import unknown
from heatwright.spec.commands import switched
from heatwright.spec.controller import ComparisonRow, Controller
from heatwright.spec.physics.derived import with_derived
from heatwright.spec.problems import Path


def row_loop(controller: Controller, row: ComparisonRow) -> str:
    """Return the loop that a row varies: the one that it names, or the only one."""
    return row.loop or next(iter(controller.loops))


def rows_have_loops(controller: Controller) -> Findings:
    """Find rows that name an undefined loop, or no loop where there are several."""
    for index, row in enumerate(controller.comparison):
        path: Path = ("comparison", index)
        if row.loop is not None:
            yield from unknown((*path, "loop"), row.loop, "loops", controller.loops)
        elif len(controller.loops) > 1:
            yield Finding(
                path,
                "this row names no loop, and the controller has several",
                f"Add loop:, such as loop: {next(iter(controller.loops))}",
                (("loops",),),
            )


def row_controller(controller: Controller, row: ComparisonRow) -> Controller:
    """Return a controller with a row's setpoint, algorithm and output in place of its loop's own.

    The row's setpoint becomes the initial one, and the loop is on, so that a run needs no operator.
    `on_for_at_most` is left out: the scenario ends the run. Other loops are as after a power-up.
    Keys cannot set a number of a row's algorithm. Raises KeyError: there is no such loop.
    """
    name = row_loop(controller, row)
    loop = controller.loops[name]
    setpoint = loop.setpoint.model_copy(update={"initial_c": row.setpoint_c})
    protection = loop.protection.model_copy(update={"on_for_at_most_s": None})
    changed = loop.model_copy(
        update={
            "algorithm": row.algorithm,
            "setpoint": setpoint,
            "protection": protection,
            "autotune": loop.autotune if row.algorithm.tunable else None,
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
            "interfaces": fixed(controller),
            "comparison": (),
        }
    )
    return with_derived(row_of)


def row_path(controller: Controller, index: int, path: Path) -> Path:
    """Translate a path in the row's controller to one in the row, or return the row's path."""
    name = row_loop(controller, controller.comparison[index])
    loop = controller.loops[name]
    row: Path = ("comparison", index)
    if path[:3] == ("loops", name, "algorithm"):
        return (*row, *path[2:])
    if path[:3] == ("loops", name, "setpoint"):
        return (*row, "setpoint")
    if path[:2] == ("outputs", loop.heater) and controller.comparison[index].output is not None:
        return (*row, "output", *path[2:])
    return row
