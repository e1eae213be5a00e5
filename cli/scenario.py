"""The scenario of a simulation: the spec's or another file's, and its length."""

from functools import partial
from pathlib import Path

from pydantic import Field, ValidationError

from heatwright.cli.beside import machine_of, read_beside
from heatwright.spec import Controller, Event, Problem, Spec
from heatwright.spec.base import Model
from heatwright.spec.checks import check
from heatwright.spec.loading.translate import findings
from heatwright.spec.loading.tree import Tree

EMPTY = "there is no scenario in this file", "Write scenario: [ … ]"


class _File(Model):
    """A file with a scenario, written as in a spec."""

    scenario: tuple[Event, ...] = Field(description="What happens, in the order of time.")


def with_scenario(spec: Spec, file: Path | None, length_s: float | None) -> Controller:
    """Return the spec's controller with the scenario of a file, shortened or extended to a length.

    Raises SpecError with all that is wrong in the file, Refused for a spec without simulation.
    """
    scenario = machine_of(spec).scenario
    if file is not None:
        scenario = read_beside(file, _File, EMPTY, partial(_checked, spec.controller)).scenario
    if length_s is not None:
        kept = (event for event in scenario if event.for_s is None and _at(event) < length_s)
        scenario = (*kept, Event.model_validate({"for": f"{length_s!r} s"}))
    return _with(spec.controller, scenario)


def _at(event: Event) -> float:
    return event.at_s or 0.0


def _with(controller: Controller, scenario: tuple[Event, ...]) -> Controller:
    assert controller.simulation is not None  # noqa: S101 - looked at before
    simulation = controller.simulation.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": simulation})


def _checked(controller: Controller, found: _File, tree: Tree) -> list[Problem]:
    """Check the scenario by the rules for a spec's own; `simulation` is not in this file."""
    return [
        tree.problem(finding.path[1:], finding.reason, finding.remedy)
        for finding in check(_with(controller, found.scenario))
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
