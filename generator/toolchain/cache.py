# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's cache: folders named by what they hold, so that nothing in them is ever stale."""

import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path


def cache_dir() -> Path:
    """`$XDG_CACHE_HOME/heatwright`, or what the system uses in its place."""
    if "XDG_CACHE_HOME" in os.environ:
        base = Path(os.environ["XDG_CACHE_HOME"])
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home()))
    else:
        base = Path.home() / ".cache"
    return base / "heatwright"


def digest(files: Mapping[str, bytes], *words: str) -> str:
    """24 hex digits that change with any path, byte or word."""
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


def folder_of(files: Mapping[str, bytes], parent: Path) -> Path:
    """Return the folder below `parent` that holds `files`, written if it is not there yet.

    It appears whole or not at all: of two processes that write it at once, one comes second and
    uses the folder of the first.
    """
    folder = parent / digest(files)
    if folder.is_dir():
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
