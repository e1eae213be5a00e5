# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's cache: folders named by a digest of what they are made from, so never stale."""

import hashlib
import shutil
import tempfile
from collections.abc import Container, Mapping
from pathlib import Path


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
