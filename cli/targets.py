"""Output files: each is checked before the work, and is written completely or not at all."""

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from heatwright.cli.ends import UNWRITTEN, Refused


def check_target(path: Path | None, suffixes: Sequence[str] = ()) -> None:
    """Refuse a file that cannot be written, before a long simulation for it begins.

    suffixes -- those allowed, such as `.png`; none: any.
    """
    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise Refused(f"{path}: the name must end with {' or '.join(suffixes)}.")
    if path.is_dir():
        raise Refused(f"{path}: is a folder; name a file.")
    from heatwright.spec.loading.user_file import OPEN_ALREADY  # noqa: PLC0415 - not only to show help

    if path.is_fifo() and not str(path).startswith(OPEN_ALREADY):
        raise Refused(f"{path}: is a pipe, which may have no reader; name a file.")
    folder = path.parent
    if not folder.is_dir():
        raise Refused(f"{path}: there is no folder {folder}; create it first.")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise Refused(f"{path}: you may not write there.")


@contextmanager
def blaming(path: Path) -> Iterator[None]:
    """Mark errors as errors of writing; name this file if an error names none (a full disk)."""
    try:
        yield
    except OSError as error:
        if error.filename is None:
            error.filename = str(path)
        named = Path(os.fsdecode(error.filename))
        if named.is_relative_to(path.parent) or path.is_relative_to(named):
            error.add_note(UNWRITTEN)
        raise


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield the path of a temporary file; if all goes well, that file replaces `path`.

    It has the suffix of `path`. After an error or Ctrl-C it is removed.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():  # a device or a pipe
        yield target
        return
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=".", suffix=target.suffix)
    os.close(handle)
    fresh = Path(name)
    try:
        with blaming(path):
            yield fresh
            fresh.chmod(0o666 & ~_umask())
            fresh.replace(target)
    finally:
        fresh.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
