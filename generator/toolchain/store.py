# SPDX-License-Identifier: GPL-3.0-or-later
"""What was built before: a folder for each project and set of tools, with its result."""

import dataclasses
import json
import os
import shutil
import time
from pathlib import Path

from heatwright.generator.toolchain.result import BuildResult

KEPT_S = 30 * 24 * 3600  # a build that nobody has asked for in this time is removed


def remember(folder: Path, result: BuildResult) -> None:
    """Write the result beside the binary; only then does the folder count."""
    record = dataclasses.asdict(result) | {"elf": result.elf.relative_to(folder).as_posix()}
    fresh = folder / "result.json.new"
    fresh.write_text(json.dumps(record), encoding="utf-8")
    fresh.replace(folder / "result.json")


def recall(folder: Path) -> BuildResult | None:
    """Return what an earlier build left in `folder`."""
    record_file = folder / "result.json"
    try:
        record = json.loads(record_file.read_text(encoding="utf-8"))
        os.utime(record_file)
        elf = folder / record.pop("elf")
        return BuildResult(elf, **record | {"cached": True}) if elf.is_file() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def forget_old(builds: Path, now_s: float | None = None) -> None:
    """Remove the builds that nobody has asked for in a long time."""
    oldest = (time.time() if now_s is None else now_s) - KEPT_S
    for lock in builds.glob("*.lock"):
        folder = lock.with_suffix("")
        newest = folder / "result.json"
        used = (newest if newest.is_file() else lock).stat().st_mtime
        if used < oldest:
            shutil.rmtree(folder, ignore_errors=True)
            lock.unlink(missing_ok=True)
