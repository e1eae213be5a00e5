"""Break the generated C in many ways, one at a time: the tests of the host build must notice."""

from pathlib import Path

import host_specs
import host_switched
import mutants_algorithms
import mutants_autotune
import mutants_commanded
import mutants_current
import mutants_guard
import mutants_loop
import mutants_outputs
import mutants_programs
import mutants_storage
import mutants_switched
import pytest
from host_builds import plain_build_of
from host_control import control_problem
from host_gate import gate_problem
from host_kept import kept_problem
from host_orders import orders_problem
from host_output import output_problem
from host_power import power_problem
from host_ready import ready_problem
from host_storage import storage_problem
from host_switching import switching_problem
from host_text import all_text_problems
from mutant import Mutant

from heatwright.sim.host import Host

MUTANTS = [
    *mutants_guard.ALL,
    *mutants_loop.ALL,
    *mutants_algorithms.ALL,
    *mutants_outputs.ALL,
    *mutants_storage.ALL,
    *mutants_commanded.ALL,
    *mutants_autotune.ALL,
    *mutants_switched.ALL,
    *mutants_current.ALL,
    *mutants_programs.ALL,
]


SWITCHED = tuple(host_switched.texts())
BY_PEOPLE = (*host_specs.PROGRAMMED, "touched")


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mutation")


def problem_of(host: Host, mutant: Mutant) -> str:
    if mutant.build in BY_PEOPLE:
        problem = control_problem(host, mutant.build) or orders_problem(host)
        return problem or power_problem(host, mutant.build)
    if mutant.build in SWITCHED:
        return control_problem(host, mutant.build) or switching_problem(host)
    if mutant.file == "settings.c":
        return storage_problem(host) or kept_problem(host)
    if mutant.file == "text.c":
        return all_text_problems(host)
    if mutant.file == "gate.c":
        return gate_problem(host)
    problem = control_problem(host, mutant.build)
    if mutant.file == "fault.c":
        problem = problem or storage_problem(host)
    if mutant.file == "output_heater.c":
        problem = problem or output_problem(host)
    if mutant.file == "loop_air.c":
        problem = problem or kept_problem(host) or ready_problem(host)
    return problem


def broken(mutant: Mutant, folder: Path, number: int) -> Host:
    build = plain_build_of(mutant.build, folder)
    text = (build.project / "src" / mutant.file).read_text(encoding="utf-8")
    found = text.count(mutant.old)
    assert found == 1, f"{mutant.old!r} stands there {found} times"
    changed = text.replace(mutant.old, mutant.new)
    return Host(build.with_changed(mutant.file, changed, folder / f"mutant{number}"))


@pytest.mark.parametrize("number", range(len(MUTANTS)), ids=[each.name for each in MUTANTS])
def test_is_noticed(number: int, folder: Path) -> None:
    mutant = MUTANTS[number]
    host = broken(mutant, folder, number)
    problem = problem_of(host, mutant)
    host.close()
    assert problem, "nothing notices it"


@pytest.mark.parametrize("build", sorted({mutant.build for mutant in MUTANTS}))
def test_unbroken_nothing_is_wrong(build: str, folder: Path) -> None:
    host = Host(plain_build_of(build, folder))
    for file in sorted({each.file for each in MUTANTS if each.build == build}):
        assert problem_of(host, Mutant(build, file, "", "")) == ""


def test_every_mutant_is_another_one() -> None:
    assert len(set(MUTANTS)) == len(MUTANTS) >= 60
