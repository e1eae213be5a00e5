"""A spec whose machine is that of a recorded step."""

from __future__ import annotations

from pathlib import Path

from heatwright.cli.ends import Refused
from heatwright.cli.identify.asked import asked_of
from heatwright.sim.identify import Unusable, fit
from heatwright.sim.identify.structure import AMBIENT_C
from heatwright.spec import Spec
from heatwright.spec.loading.user_file import read_file


def with_machine_of(path: Path, spec: Spec, log: Path) -> Spec:
    """Return the spec with the plant that `identify` finds in a log.

    Raises Refused where there is none, or where the spec has several loops: a record of one does
    not tell how they warm each other.
    """
    controller = spec.controller
    if len(controller.loops) > 1:
        raise Refused(
            f"--log: {spec.file_name} has several loops, and a record of one tells no machine for "
            "all. Put what `heatwright identify --loop` finds of each into its plant."
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
    ambient_c = next(each.value for each in found.found if each.parameter.key == AMBIENT_C)
    plant = found.structure.network(found.values)
    simulation = controller.simulation.model_copy(update={"plant": plant, "ambient_c": ambient_c})
    return spec._replace(controller=controller.model_copy(update={"simulation": simulation}))
