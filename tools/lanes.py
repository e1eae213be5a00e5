# SPDX-License-Identifier: GPL-3.0-or-later
"""How much faster machines are run at once, as lanes of arrays, than one by one.

    python tools/lanes.py [EXAMPLE …] [--seconds 600]

Both run the reference model in closed loop with machines that are drawn around the example's, and
end with the same bits (`tests/arrays`). Times are of the processor; one by one is that of a few
machines, in proportion. The translation of the model, which a process does once, counts with the
lanes.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from heatwright.sim.arrays.world import step_logs
from heatwright.sim.bench import bench
from heatwright.sim.reference.device import ReferenceDevice
from heatwright.sim.tuning.robust import Spread, drawn
from heatwright.spec import Event, load

EXAMPLES = Path(__file__).parents[1] / "spec" / "examples"
LANES = (16, 64, 256)
ALONE = 2


def ratios(name: str, seconds: float) -> list[float]:
    """Return for each number of lanes by how much they are faster."""
    controller = load(EXAMPLES / f"{name}.yaml").controller
    scenario = (Event.model_validate({"for": f"{seconds!r} s"}),)
    machines = list(drawn(controller, Spread(), max(LANES), 0))
    begun = time.process_time()
    for machine in machines[:ALONE]:
        bench(machine, ReferenceDevice(controller), scenario)
    alone_s = (time.process_time() - begun) / ALONE
    found = []
    for lanes in LANES:
        begun = time.process_time()
        step_logs([controller] * lanes, scenario, ["duty_percent"], machines=machines[:lanes])
        found.append(lanes * alone_s / (time.process_time() - begun))
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "examples", nargs="*", default=["chamber", "extruder", "kiln", "fabricator"]
    )
    parser.add_argument("--seconds", type=float, default=600.0, help="of each run")
    asked = parser.parse_args()
    print(f"{'lanes':12}" + "".join(f"{lanes:8}" for lanes in LANES))
    for example in asked.examples:
        told = "".join(f"{ratio:7.1f}×" for ratio in ratios(example, asked.seconds))
        print(f"{example:12}{told}")
