# SPDX-License-Identifier: GPL-3.0-or-later
"""What a campaign costs, and how much sooner it is done with more processes."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from measure import EXAMPLES, HEATWRIGHT, Ran, Tell, built, ran, yard_s

SPEC = EXAMPLES / "chamber.yaml"
"""Its scenario lasts for 30 minutes."""
RUNS = 100
PROCESSES = (1, 2)


def campaigns(times: int, tell: Tell) -> dict[str, Any]:
    """Run the same campaign with so many processes each time, in turns."""
    built(SPEC)
    found: dict[str, Any] = {"yard_s": yard_s(), "runs": RUNS}
    best: dict[int, Ran] = {}
    for _ in range(times):
        for processes in PROCESSES:
            tell(f"a campaign of {RUNS} runs, processes: {processes}")
            one = campaign(processes)
            best[processes] = min(best.get(processes, one), one, key=lambda each: each.processor_s)
    found["processes"] = {
        str(number): {"processor_s": one.processor_s, "wall_s": one.wall_s}
        for number, one in best.items()
    }
    return found


def campaign(processes: int) -> Ran:
    """Run one from its beginning."""
    with TemporaryDirectory() as parent:
        kept = Path(parent) / "kept"
        command = (HEATWRIGHT, "campaign", SPEC, "--runs", str(RUNS), "--output", kept)
        return ran((*command, "--processes", str(processes), "--json"))
