# SPDX-License-Identifier: GPL-3.0-or-later
"""What more loops, more faults and longer runs cost.

The machine has as many chambers as there are loops: each with sensor, heater and plant of its own.
"""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml
from measure import EXAMPLES, HEATWRIGHT, Tell, built, ran, yard_s

LOOPS = (1, 2, 3, 4)
"""More lines of 1-Wire would wait for each other for too long."""
HOURS = (0.5, 1, 2, 4, 8)
SPEC = EXAMPLES / "chamber.yaml"


def growth(times: int, tell: Tell) -> dict[str, Any]:
    """Measure the three."""
    with TemporaryDirectory() as folder:
        return {
            "yard_s": yard_s(),
            "loops": [of_loops(Path(folder), count, times, tell) for count in LOOPS],
            "length": [of_length(hours, times, tell) for hours in HOURS],
        }


def of_loops(folder: Path, count: int, times: int, tell: Tell) -> dict[str, Any]:
    """Simulate and verify chambers side by side."""
    tell(f"{count} loops")
    spec = folder / f"chambers{count}.yaml"
    spec.write_text(json.dumps(chambers(count)), encoding="utf-8")
    built(spec)
    simulate = [ran((HEATWRIGHT, "simulate", spec)).processor_s for _ in range(times)]
    verify = [ran((HEATWRIGHT, "verify", spec, "--json")) for _ in range(times)]
    return {
        "loops": count,
        "simulate_s": min(simulate),
        "verify_s": min(each.processor_s for each in verify),
        "faults": len(json.loads(verify[0].output)["faults"]),
    }


def of_length(hours: float, times: int, tell: Tell) -> dict[str, Any]:
    """Simulate the chamber for so long."""
    tell(f"{hours:g} h")
    built(SPEC)
    command = (HEATWRIGHT, "simulate", SPEC, "--for", f"{hours:g} h")
    return {"hours": hours, "simulate_s": min(ran(command).processor_s for _ in range(times))}


def chambers(count: int) -> dict[str, Any]:
    """Return the spec of a controller with so many chambers side by side."""
    one = yaml.safe_load(SPEC.read_text(encoding="utf-8"))
    plant = one["simulation"]["plant"]
    loop = {key: value for key, value in one["loops"]["air"].items() if key != "fan"}
    loop["setpoint"]["initial"] = "50 °C"
    numbers = range(count)

    def own(number: int, node: str) -> str:
        return node if node == "ambient" else f"{node}{number}"

    return {
        "heatwright": 1,
        "controller": {"name": "chambers", "board": "mega2560"},
        "sensors": {f"air{n}": {"kind": "ds18b20", "pin": f"A{n}"} for n in numbers},
        "outputs": {
            f"heater{n}": {"kind": "digital", "pin": f"D{22 + n}", "power": "240 W"}
            for n in numbers
        },
        "loops": {
            f"air{n}": {**loop, "sensor": f"air{n}", "heater": f"heater{n}"} for n in numbers
        },
        "safety": one["safety"],
        "simulation": {
            "ambient": one["simulation"]["ambient"],
            "plant": {
                "kind": plant["kind"],
                "nodes": {
                    own(n, node): capacity
                    for n in numbers
                    for node, capacity in plant["nodes"].items()
                },
                "links": [
                    {**link, "between": [own(n, node) for node in link["between"]]}
                    for n in numbers
                    for link in plant["links"]
                ],
                "heat": {f"heater{n}": f"element{n}" for n in numbers},
                "sense": {f"air{n}": {"node": f"air{n}", "lag": "8 s"} for n in numbers},
            },
            "scenario": [{"for": "30 min"}],
        },
    }
