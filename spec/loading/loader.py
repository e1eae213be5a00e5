"""Loads a spec: bytes → text → tree → models → checks. Reports all problems of a stage together."""

import os
import zlib
from collections.abc import Collection
from json import dumps
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from pydantic import ValidationError

from heatwright.spec.checks import check
from heatwright.spec.checks.agree import agreed
from heatwright.spec.checks.finding import Finding
from heatwright.spec.controller import Controller
from heatwright.spec.loading.error_recovery import without_broken_parts
from heatwright.spec.loading.text import LARGEST_FILE, Unreadable, decode
from heatwright.spec.loading.translate import findings
from heatwright.spec.loading.tree import Data, Tree, parse
from heatwright.spec.loading.user_file import STDIN, read_file
from heatwright.spec.problems import Path, Problem, SpecError

MOST_PROBLEMS = 100
"""Maximum number of problems that are reported at once."""


LATER = (
    "monitors", "proof", "tolerances", "accuracy", "tachometer", "adjust", "limits_adjustable",
    "on_for_at_most", "inputs", "also", "agreement", "self_checks",
)  # fmt: skip
"""Keys that were added to the language when firmwares already existed."""


class Spec(NamedTuple):
    """A controller that passed every check, and the position of each part in the file."""

    controller: Controller
    file_name: str
    """The file's name without its folders."""
    tree: Tree

    def line(self, path: Path) -> int:
        """Return the line, from 1, of an entry, or of the nearest one above it in the tree."""
        return self.tree.position(path)[0]

    @property
    def digest(self) -> str:
        """CRC-32, eight hex digits, of everything in the spec that affects the firmware."""
        return digest(self.controller)


def digest(controller: Controller) -> str:
    """CRC-32 of the canonical JSON of a controller without its simulation and comparison.

    Unused keys of `LATER` are left out, so that data stored under an older digest stay valid.
    """
    shaping = controller.model_dump(by_alias=True, exclude={"simulation", "comparison"})
    shaping = _without_unused(shaping)
    text = dumps(shaping, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return f"{zlib.crc32(text.encode()):08x}"


def _without_unused(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_without_unused(each) for each in value]
    if not isinstance(value, dict):
        return value
    return {key: _without_unused(each) for key, each in value.items() if each or key not in LATER}


def load(path: str | os.PathLike[str]) -> Spec:
    """Load a spec from a file, or from standard input if it is `-`.

    Raises SpecError: the spec is wrong, with all problems; OSError: the file cannot be read.
    """
    file = os.fspath(path)
    return _load(read_file(file, LARGEST_FILE + 1), file)


def load_text(text: str | bytes, file: str = "spec.yaml") -> Spec:
    """Load a spec from text; `file` is its name in the messages."""
    return _load(text.encode(errors="surrogatepass") if isinstance(text, str) else text, file)


def _load(data: bytes, file: str) -> Spec:
    try:
        tree = parse(decode(data, file), file)
    except Unreadable as error:
        raise SpecError((error.problem,)) from None
    name = "stdin" if file == STDIN else FilePath(file).name
    controller, problems = _examined(tree)
    if controller is None or problems:
        raise SpecError(problems)
    return Spec(controller, name, tree)


def with_data(spec: Spec, data: Data) -> tuple[Spec, tuple[Problem, ...]]:
    """Return a spec with data in place of its file's, all defaults derived again; and problems.

    The position of a problem is that of its entry in the file, or of the nearest one above it.
    Raises SpecError: no controller can be made of the data.
    """
    tree = Tree(spec.tree.file)
    tree.data, tree.positions = data, spec.tree.positions
    controller, problems = _examined(tree)
    if controller is None:
        raise SpecError(problems)
    return spec._replace(controller=controller, tree=tree), problems


def _examined(tree: Tree) -> tuple[Controller | None, tuple[Problem, ...]]:
    """Return the controller, made of the valid entries, and all problems."""
    problems = dict(tree.problems)
    controller = _validated(tree, problems) if () not in problems else None
    checked = check(controller) if controller is not None else ()
    sound = (finding for finding in checked if not _rests_on(finding, problems))
    found = [problem_of(tree, finding) for finding in agreed(sound)]
    return controller, _sorted([*problems.values(), *found])


def _validated(tree: Tree, problems: dict[Path, Problem]) -> Controller | None:
    """Make the controller of the valid entries; add all errors to the problems."""
    try:
        controller: Controller | None = Controller.model_validate(tree.data)
    except ValidationError as error:
        for path, reason, remedy in findings(error, Controller, tree.position):
            if not any(path[:depth] in problems for depth in range(len(path) + 1)):
                problems[path] = tree.problem(path, reason, remedy)
        controller = without_broken_parts(tree.data)
    return controller


def problem_of(tree: Tree, finding: Finding) -> Problem:
    """Make a problem of a finding: with its position, and the name of a key to delete.

    The problem says so if it concerns the default value of a key that the file does not contain.
    """
    default = "" if finding.path in tree.positions else "with the default value, "
    key = finding.path[-1] if finding.path else 0
    name = key if isinstance(key, str) else "it"
    remedy = finding.remedy.replace("Delete it", f"Delete {name}", 1)
    return tree.problem(finding.path, default + finding.reason, remedy)


def _rests_on(finding: Finding, broken: Collection[Path]) -> bool:
    """Return whether a finding may be caused by a broken entry."""
    return any(
        _overlap(path, other) for path in (finding.path, *finding.because_of) for other in broken
    )


def _overlap(path: Path, other: Path) -> bool:
    """Return whether one entry is part of the other, or is it."""
    common = min(len(path), len(other))
    return path[:common] == other[:common]


def _sorted(problems: list[Problem]) -> tuple[Problem, ...]:
    ordered = sorted(problems, key=lambda problem: (problem.line, problem.column))
    if len(ordered) > MOST_PROBLEMS:
        left_out = len(ordered) - MOST_PROBLEMS
        reason = f"there are {left_out} more problems from here on"
        last = ordered[MOST_PROBLEMS]._replace(path="", reason=reason)
        ordered[MOST_PROBLEMS:] = [last._replace(remedy="Correct the others first")]
    return tuple(ordered)
