# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's cache: folders named by a digest of what they are made from, so never stale.

An earlier build is such a folder, for each project and set of tools, with its result.
"""

import dataclasses
import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Container, Mapping
from pathlib import Path

from heatwright.generator.toolchain.result import BuildResult


def digest(files: Mapping[str, bytes], *words: str) -> str:
    """Return 24 hex digits that change with any path, byte or word."""
    total = hashlib.sha256()
    for word in words:
        total.update(b"%d:%s" % (len(word.encode()), word.encode()))
    for path in sorted(files):
        total.update(b"%d:%s%d:" % (len(path.encode()), path.encode(), len(files[path])))
        total.update(files[path])
    return total.hexdigest()[:24]


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write `files` (paths with `/`) below `folder`."""
    for path, content in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)


def folder_of(files: Mapping[str, bytes], parent: Path, changing: Container[str] = ()) -> Path:
    """Return the folder below `parent` that holds `files`, written if it is not there yet.

    It is created completely or not at all: if two processes write it at once, the second one uses
    the folder of the first. A damaged file in it is written again, except for those in `changing`,
    which the folder's user may change.
    """
    folder = parent / digest(files)
    if folder.is_dir():
        for path, content in files.items():
            if path not in changing and not _holds(folder / path, content):
                _mend(folder / path, content)
        return folder
    parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix=".new-", dir=parent))
    try:
        write_files(fresh, files)
        fresh.chmod(0o755)
        try:
            fresh.rename(folder)
        except OSError:
            if not folder.is_dir():
                raise
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return folder


def _holds(file: Path, content: bytes) -> bool:
    try:
        return file.read_bytes() == content
    except OSError:
        return False


def _mend(file: Path, content: bytes) -> None:
    """Replace the content in one step: a reader never finds half of it."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, prefix=".new-", delete=False) as fresh:
        fresh.write(content)
    Path(fresh.name).chmod(0o644)
    Path(fresh.name).replace(file)


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
