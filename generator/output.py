"""Write a project to a folder, or compare it with one. The user's own files are never changed."""

import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from heatwright.generator.plan.parts import MARK

_BANNER = re.compile(rb"((//|;|#|<!--) |{\"_\": \")" + MARK.encode() + b" from ")
"""First line of each generated file; a file with these words further down may be the user's."""


class OutputRefused(Exception):
    """The folder has something that must not be replaced; the text says what, and what to do."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One file that differs from the project: `missing`, `changed` or `extra`."""

    path: str
    state: str


def write(files: Mapping[str, str], folder: Path) -> tuple[Path, ...]:
    """Write the files that differ, and return their paths.

    The user's own files are never replaced: if a file at one of the paths does not have our mark,
    nothing is written. Raises OutputRefused, OSError.
    """
    targets = {folder / _inside(path): text for path, text in files.items()}
    for target in targets:
        _refuse_foreign(folder, target)
    written = []
    for target, text in targets.items():
        data = text.encode()
        if target.is_file() and target.read_bytes() == data:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        _replace(target, data)
        written.append(target)
    return tuple(written)


def compare(files: Mapping[str, str], folder: Path) -> tuple[Difference, ...]:
    """Return missing and changed files, and generated files that the project no longer has."""
    differences = []
    for path, text in files.items():
        target = folder / _inside(path)
        if not target.is_file():
            differences.append(Difference(path, "missing"))
        elif target.read_bytes() != text.encode():
            differences.append(Difference(path, "changed"))
    differences += [Difference(path, "extra") for path in left_over(files, folder)]
    return tuple(differences)


def left_over(files: Mapping[str, str], folder: Path) -> tuple[str, ...]:
    """Find generated files that this spec no longer generates, in the project's folders."""
    found = (
        path
        for place in sorted({(folder / _inside(path)).parent for path in files})
        if place.is_dir()
        for path in sorted(place.iterdir())
        if path.is_file() and not path.is_symlink() and _is_ours(path)
    )
    names = (path.relative_to(folder).as_posix() for path in found)
    return tuple(name for name in names if name not in files)


def _inside(path: str) -> PurePosixPath:
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts:
        raise ValueError(f"{path!r} leads out of the output folder")
    return pure


def _is_ours(path: Path) -> bool:
    with path.open("rb") as file:
        return _BANNER.match(file.read(100)) is not None


def _refuse_foreign(folder: Path, target: Path) -> None:
    for step in (target, *target.parents):
        if step == folder.parent:
            break
        if step.is_symlink() and step != folder:
            raise OutputRefused(
                f"{step} is a link and might lead elsewhere. Remove it, or choose another folder."
            )
        if step != target and step.exists() and not step.is_dir():
            raise OutputRefused(
                f"{step} is a file where a folder is needed. Choose another folder."
            )
    if target.is_dir():
        raise OutputRefused(f"{target} is a folder where a file is needed. Choose another folder.")
    if target.exists() and not (target.is_file() and _is_ours(target)):
        raise OutputRefused(
            f"{target} was not written by heatwright and would be replaced. "
            "Move it away, or choose another folder."
        )


def _replace(target: Path, data: bytes) -> None:
    """Write a file completely or not at all: no reader finds half, Ctrl-C leaves the old one."""
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        temporary.chmod(0o644)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)
