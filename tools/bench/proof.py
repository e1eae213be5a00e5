# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user waits for most: `verify`, in yards; and the closed loop, in times real time."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from measure import EXAMPLES, HEATWRIGHT, ROOT, Tell, built, ran, yard_command, yard_s

VERIFIED = ("chamber", "extruder", "feeder", "fabricator", "kiln", "kiln_uno")
LOOPS = ("chamber", "kiln", "extruder", "fabricator")
LOOP = Path(__file__).with_name("loop.py")


def verified(times: int, tell: Tell, names: Iterable[str] = VERIFIED) -> dict[str, Any]:
    """Verify examples, each between yards: its binary has been built before."""
    return {name: one_verified(EXAMPLES / f"{name}.yaml", times, tell) for name in names}


def one_verified(spec: Path, times: int, tell: Tell) -> dict[str, Any]:
    """Verify one spec."""
    tell(f"verify {spec.stem}")
    built(spec)
    yards, runs = [], []
    for _ in range(times):
        yards.append(ran(yard_command()).processor_s)
        runs.append(ran((HEATWRIGHT, "verify", spec, "--json")))
    return {
        "yard_s": min(*yards, ran(yard_command()).processor_s),
        "processor_s": min(run.processor_s for run in runs),
        "faults": len(json.loads(runs[0].output)["faults"]),
    }


def loops(times: int, tell: Tell, against: Path | None, names: Iterable[str] = LOOPS) -> Any:
    """Run closed loops; `against`: a folder with another checkout, whose runs take turns.

    Each runs its own example of the name: an older one may not know what ours says.
    """
    checkouts = {"now": (Path(sys.executable), EXAMPLES)}
    if against is not None:
        python = against / ".venv" / "bin" / "python"
        checkouts["before"] = (python, against / EXAMPLES.relative_to(ROOT))
    found: dict[str, Any] = {"yard_s": yard_s()}
    for name in names:
        tell(f"closed loop of {name}")
        found[name] = fastest(name, times, checkouts)
    return found


def fastest(name: str, times: int, checkouts: dict[str, tuple[Path, Path]]) -> dict[str, Any]:
    """Return the run of least processor time, of each checkout: its Python, and its examples."""
    runs: dict[str, list[Any]] = {each: [] for each in checkouts}
    for _ in range(times):
        for each, (python, examples) in checkouts.items():
            command = (python, LOOP, examples / f"{name}.yaml")
            runs[each].append(json.loads(ran(command).output))
    return {each: max(of, key=lambda run: run["speed"]) for each, of in runs.items()}
