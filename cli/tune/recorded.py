"""Replaces the machine of a spec by the one fitted to a recorded step."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from heatwright.cli.ends import Refused
from heatwright.cli.identify.asked import asked_of
from heatwright.cli.identify.block import block
from heatwright.sim.identify import Unusable, fit
from heatwright.spec import Spec
from heatwright.spec.loading.loader import with_data
from heatwright.spec.loading.tree import parse
from heatwright.spec.loading.user_file import read_file

_AT_NODES: dict[str, Callable[[str, Any], str | None]] = {
    "heat": lambda _, node: str(node),
    "sense": lambda _, sense: sense.get("node"),
    "bears": lambda node, _: node,
}
"""Keys of a plant in YAML, each with a function that returns the node of an entry, or None."""


def with_machine_of(path: Path, spec: Spec, log: Path) -> Spec:
    """Return the spec with the plant that `identify` finds in a log.

    Raises Refused: it finds none, or the spec has several loops; a record of one does not show how
    they warm each other.
    """
    controller = spec.controller
    if len(controller.loops) > 1:
        raise Refused(
            f"--log: {spec.file_name} has several loops, and a record of one loop does not show "
            "the others. Paste what `heatwright identify --loop` finds for each into its plant."
        )
    if controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is nothing to try gains in. Paste "
            "what `heatwright identify` finds into it."
        )
    asked = asked_of(path, None, columns=None, power_w=None, full=None, period_s=None, bodies=1)
    try:
        found = fit(asked.record(read_file(log)), asked.structure, age_s=asked.age_s)
    except Unusable as error:
        raise Refused(f"{log}: {error}.") from None
    plant = parse(block(found, log.name), str(log)).data
    changed, problems = with_data(spec, _with_plant(spec.tree.data, plant))
    text = "\n".join(str(each) for each in problems)
    if any(each.path.startswith("simulation.plant") for each in problems):
        raise Refused(
            f"--log: a record of one step does not show all parts of the machine of "
            f"{spec.file_name}. Paste what `heatwright identify` finds into a copy, and complete "
            f"it:\n{text}"
        )
    if text:
        click.echo(f"With the machine of {log}, `check` would refuse this spec:\n{text}", err=True)
    return changed


def _with_plant(written: Any, found: Any) -> dict[str, Any]:
    """Replace ambient and plant in a spec's YAML, as if the output of `identify` were pasted.

    Keys that a record does not show stay: the tolerance, and those of nodes that still exist.
    """
    simulation, plant = written["simulation"], found["simulation"]["plant"]
    before = simulation["plant"]
    if before["kind"] == plant["kind"]:
        if "tolerance" in before:
            plant["tolerance"] = before["tolerance"]
        if before.get("filament", {}).get("node") in plant["nodes"]:
            plant["filament"] = before["filament"]
        for key, node_of in _AT_NODES.items():
            kept = {
                name: each
                for name, each in before.get(key, {}).items()
                if node_of(name, each) in {None, *plant["nodes"]}
            }
            if kept:
                plant[key] = kept | plant.get(key, {})
    fresh = {**simulation, "ambient": found["simulation"]["ambient"], "plant": plant}
    return {**written, "simulation": fresh}
