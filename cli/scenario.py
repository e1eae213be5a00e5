"""The scenario of a simulation: the spec's or another file's, and its length."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field, ValidationError

from heatwright.cli.ends import Refused
from heatwright.spec import Controller, Event, Problem, Spec, SpecError
from heatwright.spec.base import Model
from heatwright.spec.checks import check
from heatwright.spec.loading.text import LARGEST_FILE, Unreadable, decode
from heatwright.spec.loading.translate import findings
from heatwright.spec.loading.tree import Tree, parse
from heatwright.spec.loading.user_file import read_file


class _File(Model):
    """A file with a scenario, written as in a spec."""

    scenario: tuple[Event, ...] = Field(description="What happens, in the order of time.")


def with_scenario(spec: Spec, file: Path | None, length_s: float | None) -> Controller:
    """Return the spec's controller with the scenario of a file, shortened or extended to a length.

    Raises SpecError with all that is wrong in the file, Refused for a spec without simulation.
    """
    controller = spec.controller
    if controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to run it on. "
            "Describe one, as `heatwright init` shows."
        )
    scenario = controller.simulation.scenario
    if file is not None:
        scenario = _load(controller, file)
    if length_s is not None:
        kept = (event for event in scenario if event.for_s is None and _at(event) < length_s)
        scenario = (*kept, Event.model_validate({"for": f"{length_s!r} s"}))
    return _with(controller, scenario)


def _at(event: Event) -> float:
    return event.at_s or 0.0


def _with(controller: Controller, scenario: tuple[Event, ...]) -> Controller:
    assert controller.simulation is not None  # noqa: S101 - looked at before
    simulation = controller.simulation.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": simulation})


def _load(controller: Controller, file: Path) -> tuple[Event, ...]:
    try:
        tree = parse(decode(read_file(file, LARGEST_FILE + 1), str(file)), str(file))
    except Unreadable as error:
        raise SpecError((error.problem,)) from None
    found, problems = _read(tree)
    if found is not None and not problems:
        problems = _checked(_with(controller, found), tree)
    if problems:
        raise SpecError(tuple(sorted(problems, key=lambda each: (each.line, each.column))))
    return found or ()


def _read(tree: Tree) -> tuple[tuple[Event, ...] | None, list[Problem]]:
    problems = dict(tree.problems)
    if tree.data is None:
        return None, [
            tree.problem((), "there is no scenario in this file", "Write scenario: [ … ]")
        ]
    try:
        return _File.model_validate(tree.data).scenario, list(problems.values())
    except ValidationError as error:
        for path, reason, remedy in findings(error, _File):
            problems.setdefault(path, tree.problem(path, reason, remedy))
    return None, list(problems.values())


def _checked(controller: Controller, tree: Tree) -> list[Problem]:
    """Check the scenario by the rules for a spec's own; `simulation` is not in this file."""
    return [
        tree.problem(finding.path[1:], finding.reason, finding.remedy)
        for finding in check(controller)
        if finding.path[:2] == ("simulation", "scenario")
    ]


def read_length(text: str) -> float:
    """Read a scenario's length, as `for` has it, in s; raises ValueError with what is wrong."""
    try:
        length_s = Event.model_validate({"for": text}).for_s
    except ValidationError as error:
        _, reason, remedy = next(iter(findings(error, Event)))
        raise ValueError(f"{reason}. {remedy}.") from None
    assert length_s is not None  # noqa: S101 - it was given
    return length_s
