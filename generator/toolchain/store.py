# SPDX-License-Identifier: GPL-3.0-or-later
"""Earlier builds: a folder for each project and set of tools, with its result."""

import dataclasses
import json
import os
import shutil
import time
from collections.abc import Mapping
from pathlib import Path

from heatwright.generator.toolchain.cache import digest
from heatwright.generator.toolchain.result import BuildResult

KEPT_S = 30 * 24 * 3600  # a build not used for this time is removed


def remember(folder: Path, result: BuildResult) -> None:
    """Write the result beside the binary; a folder without a result is ignored."""
    record = dataclasses.asdict(result) | {"elf": result.elf.relative_to(folder).as_posix()}
    fresh = folder / "result.json.new"
    sealed = {"record": record, "seal": _seal(result.elf, record)}
    fresh.write_text(json.dumps(sealed), encoding="utf-8")
    fresh.replace(folder / "result.json")


def recall(folder: Path) -> BuildResult | None:
    """Return the result of an earlier build in `folder`; None if it is missing or damaged."""
    record_file = folder / "result.json"
    try:
        sealed = json.loads(record_file.read_text(encoding="utf-8"))
        record = sealed["record"]
        elf = folder / record["elf"]
        if _seal(elf, record) != sealed["seal"]:
            return None
        os.utime(record_file)
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return BuildResult(**record | {"elf": elf, "cached": True})


def _seal(elf: Path, record: Mapping[str, object]) -> str:
    """Return digits that change with any byte of the binary, its image and the record."""
    made = (elf, elf.with_suffix(".hex"))  # a program that does not fit may have no image
    files = {path.suffix: path.read_bytes() for path in made if path.is_file()}
    return digest(files, json.dumps(record, sort_keys=True))


def forget_old(builds: Path, now_s: float | None = None) -> None:
    """Remove the builds that have not been used for a long time."""
    oldest = (time.time() if now_s is None else now_s) - KEPT_S
    for lock in builds.glob("*.lock"):
        folder = lock.with_suffix("")
        newest = folder / "result.json"
        used = (newest if newest.is_file() else lock).stat().st_mtime
        if used < oldest:
            shutil.rmtree(folder, ignore_errors=True)
            lock.unlink(missing_ok=True)
