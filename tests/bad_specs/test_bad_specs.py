"""Every bad spec is refused with exactly its messages, and every check has a spec that needs it."""

import re
from collections.abc import Callable
from functools import cache

import pytest
import yaml
from rig.bad_specs import bases, cases

from heatwright.spec import Controller, SpecError, ThermalNetwork, load_text
from heatwright.spec.checks import CHECKS, SIMULATION_CHECKS
from heatwright.spec.checks.finding import Findings

TABLES = {"CHECKS": CHECKS, "SIMULATION_CHECKS": SIMULATION_CHECKS}


@cache
def refused(name: str) -> tuple[SpecError, frozenset[str]]:
    """Load a bad spec: the error, and the names of the checks whose findings its messages tell."""
    case, told = cases()[name], set()

    def listening(check: Callable[..., Findings]) -> Callable[..., Findings]:
        def listen(*told_of: Controller | ThermalNetwork) -> Findings:
            for finding in check(*told_of):
                words = f": {finding.reason}. "  # the remedy may be that of a stricter check
                if words in case.expected.replace("with the default value, ", ""):
                    told.add(check.__name__)
                yield finding

        return listen

    with pytest.MonkeyPatch.context() as patch:
        for table, checks in TABLES.items():
            patch.setattr(f"heatwright.spec.checks.{table}", tuple(map(listening, checks)))
        return case.refusal(), frozenset(told)


@pytest.mark.parametrize("base", bases())
def test_what_they_are_made_of_is_good(base: str) -> None:
    assert load_text(bases()[base])


@pytest.mark.parametrize("name", cases())
def test_messages(name: str) -> None:
    error, _ = refused(name)
    assert str(error) == cases()[name].expected
    places = [(problem.line, problem.column) for problem in error.problems]
    assert places == sorted(places), "they stand in the order of the file"


@pytest.mark.parametrize("name", cases())
def test_without_libyaml(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """PyYAML may have been installed without its C half; the slower half differs in its words."""
    monkeypatch.setattr("heatwright.spec.loading.tree._Loader", yaml.BaseLoader)
    expected = cases()[name].expected
    assert str(cases()[name].refusal()) == expected or "this is not YAML: " in expected


@pytest.fixture(scope="module")
def told() -> set[str]:
    """The names of the checks of which some message tells a finding."""
    return {check for name in cases() for check in refused(name)[1]}


@pytest.mark.parametrize("check", CHECKS + SIMULATION_CHECKS, ids=lambda check: check.__name__)
def test_no_check_without_a_spec_that_needs_it(
    check: Callable[..., Findings], told: set[str]
) -> None:
    assert check.__name__ in told


PHYSICS = """
never to the highest setpoint, alone heats to, this healthy plant needs, this current gives,
this healthy plant heats at, coasts up to, continues to rise for, swings by,
W are too little, this plant cools by, through the whole band, may jump by
"""


@pytest.mark.parametrize("words", re.split(r",\s+", PHYSICS.strip()))
def test_no_physics_without_a_spec_that_needs_it(words: str) -> None:
    assert any(words in case.expected.replace(",", "") for case in cases().values())
