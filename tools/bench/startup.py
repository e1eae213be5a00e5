# SPDX-License-Identifier: GPL-3.0-or-later
"""Start-up: the commands that a user waits for, against the yard and against ESPHome's."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from measure import EXAMPLES, HEATWRIGHT, JUDGES, Command, least_s, yard_command

SPEC = EXAMPLES / "chamber.yaml"
TWIN = Path(__file__).with_name("chamber_esphome.yaml")
ESPHOME = JUDGES / "esphome" / "bin" / "esphome"
PAIRS = {"check --quick": "config", "generate": "compile --only-generate"}
"""What reads a spec, and what makes sources of it: ours and ESPHome's. Neither compiles, and
ESPHome has no machine that it could run, as `check` without `--quick` does."""


def startup(times: int) -> dict[str, Any]:
    """Measure all in one run."""
    with TemporaryDirectory() as parent:
        folder = Path(parent)
        found = least_s(commands(folder), times, cwd=folder)
    yard = found.pop("yard")
    return {
        "yard_s": yard,
        "lines": {"ours": lines(SPEC), "theirs": lines(TWIN)},
        "ours": {name: s for name, s in found.items() if not name.startswith("esphome ")},
        "esphome": {
            name.removeprefix("esphome "): s
            for name, s in found.items()
            if name.startswith("esphome ")
        },
    }


def commands(folder: Path) -> Mapping[str, Command]:
    """Return what is measured, by its name."""
    ours: dict[str, Command] = {
        "yard": yard_command(),
        "--help": (HEATWRIGHT, "--help"),
        "check --quick": (HEATWRIGHT, "check", "--quick", SPEC),
        "generate": (HEATWRIGHT, "generate", SPEC, "-o", folder / "firmware"),
        "check": (HEATWRIGHT, "check", SPEC),
    }
    if not ESPHOME.exists():
        print(f"  without ESPHome: {ESPHOME} is missing (make peers installs it)")
        return ours
    twin = folder / TWIN.name
    shutil.copy(TWIN, twin)
    return ours | {f"esphome {each}": (ESPHOME, *each.split(), twin) for each in PAIRS.values()}


def lines(path: Path) -> int:
    """Count the lines of a spec that say something: neither blank nor a comment."""
    texts = (line.strip() for line in path.read_text(encoding="utf-8").splitlines())
    return sum(1 for text in texts if text and not text.startswith("#"))
