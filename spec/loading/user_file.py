"""Files that the user names: read once, without waiting for a pipe that may never end."""

import errno
import os
import stat
import sys

UNREAD = "cannot be read"
"""The note that is added to an error while reading."""
STDIN = "-"
OPEN_ALREADY = ("/dev/stdin", "/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/self/fd/")
"""Names of files that the shell has opened: a pipe there has a program at its other end."""


def read_file(path: str | os.PathLike[str], most: int = -1) -> bytes:
    """Read a file, or standard input if the name is `-`; no more than `most` bytes.

    Raises OSError: it cannot be read, or is a pipe or a device, which might never end or begin.
    """
    file = os.fspath(path)
    try:
        if file == STDIN and sys.stdin is not None:
            return sys.stdin.buffer.read(most)
        if not file.startswith(OPEN_ALREADY):
            _refuse_special(file)
        with open(file, "rb") as stream:  # noqa: PTH123 - a name, as the user wrote it
            return stream.read(most)
    except OSError as error:
        if error.filename is None:
            error.filename = file
        error.add_note(UNREAD)
        raise


def _refuse_special(file: str) -> None:
    kind = os.stat(file).st_mode  # noqa: PTH116 - a name, as the user wrote it
    if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        raise OSError(errno.EINVAL, "it is no regular file", file)
