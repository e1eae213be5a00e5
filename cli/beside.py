"""Files beside a spec: a scenario, and the variations of a campaign."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from heatwright.cli.ends import Refused
from heatwright.spec import Problem, Simulation, Spec, SpecError
from heatwright.spec.base import Model
from heatwright.spec.loading.text import LARGEST_FILE, Unreadable, decode
from heatwright.spec.loading.translate import findings
from heatwright.spec.loading.tree import Tree, parse
from heatwright.spec.loading.user_file import read_file

M = TypeVar("M", bound=Model)


def read_beside(
    file: Path,
    model: type[M],
    empty: tuple[str, str],
    checked: Callable[[M, Tree], Iterable[Problem]],
) -> M:
    """Read a file.

    empty -- reason and remedy for a file without content; checked -- finds what is wrong in a file
    whose values are all valid.

    Raises SpecError with all that is wrong in the file, OSError if it cannot be read.
    """
    try:
        tree = parse(decode(read_file(file, LARGEST_FILE + 1), str(file)), str(file))
    except Unreadable as error:
        raise SpecError((error.problem,)) from None
    found, problems = None, dict(tree.problems)
    if tree.data is None:
        problems = {(): tree.problem((), *empty)}
    else:
        try:
            found = model.model_validate(tree.data)
        except ValidationError as error:
            for path, reason, remedy in findings(error, model):
                problems.setdefault(path, tree.problem(path, reason, remedy))
    told = list(problems.values())
    if found is not None and not told:
        told = list(checked(found, tree))
    if told:
        raise SpecError(tuple(sorted(told, key=lambda each: (each.line, each.column))))
    assert found is not None  # noqa: S101 - else there were problems
    return found


def machine_of(spec: Spec) -> Simulation:
    """Return the spec's machine. Raises Refused if it has none."""
    if spec.controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to run it on. "
            "Describe one, as `heatwright init` shows."
        )
    return spec.controller.simulation
