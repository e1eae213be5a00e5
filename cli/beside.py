"""Files beside a spec: a scenario, and the variations of a campaign."""

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TypeVar

from pydantic import Field, ValidationError

from heatwright.cli.ends import Refused
from heatwright.spec import Controller, Event, Problem, Simulation, Spec, SpecError
from heatwright.spec.base import Model
from heatwright.spec.checks import check
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
    """Read a YAML file, and check it.

    empty -- reason and remedy for a file without content; checked -- finds what is wrong in a file
    whose values are all valid. Raises SpecError: the file is wrong, with all problems; OSError: it
    cannot be read.
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
    """Return the spec's machine. Raises Refused: it has none."""
    if spec.controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to run it on. "
            "Describe one, as `heatwright init` shows."
        )
    return spec.controller.simulation


NO_SCENARIO = "there is no scenario in this file", "Write scenario: [ … ]"


class _ScenarioFile(Model):
    """A file with a scenario, written as in a spec."""

    scenario: tuple[Event, ...] = Field(description="What happens, in the order of time.")


def with_scenario(spec: Spec, file: Path | None, length_s: float | None) -> Controller:
    """Return the spec's controller with the scenario of a file, shortened or extended to a length.

    Raises SpecError: the file is wrong, with all problems; Refused: the spec has no simulation.
    """
    scenario = machine_of(spec).scenario
    if file is not None:
        scenario = read_beside(
            file, _ScenarioFile, NO_SCENARIO, partial(_checked_scenario, spec.controller)
        ).scenario
    if length_s is not None:
        events = (event for event in scenario if event.for_s is None)
        kept = (event for event in events if (event.at_s or 0.0) < length_s)
        scenario = (*kept, Event.model_validate({"for": f"{length_s!r} s"}))
    return _with_events(spec.controller, scenario)


def _with_events(controller: Controller, scenario: tuple[Event, ...]) -> Controller:
    simulation = controller.simulated.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": simulation})


def _checked_scenario(controller: Controller, found: _ScenarioFile, tree: Tree) -> list[Problem]:
    """Check a scenario by the rules for a spec's; in its file no key `simulation` is above it."""
    return [
        tree.problem(finding.path[1:], finding.reason, finding.remedy)
        for finding in check(_with_events(controller, found.scenario))
        if finding.path[:2] == ("simulation", "scenario")
    ]


def read_length(text: str) -> float:
    """Read a scenario's length, written as for the key `for`, in s; raises ValueError."""
    try:
        length_s = Event.model_validate({"for": text}).for_s
    except ValidationError as error:
        _, reason, remedy = next(iter(findings(error, Event)))
        raise ValueError(f"{reason}. {remedy}.") from None
    assert length_s is not None  # noqa: S101 - it was given
    return length_s
