"""Break what keeps programs and progress, one line at a time: the checks must notice."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from storage_mutants import ALL, Mutant
from storage_programs import Programs, programs_problem
from storage_progress import Progresses, progress_problem
from storage_settings import Settings, settings_problem
from storage_specs import build_of

from heatwright.sim.host import HostBuild

MACHINES = {"programs.c": "few", "progress.c": "few", "settings.c": "typed"}
MOST_S = 60
"""For what takes two."""


Plain = Callable[[str], HostBuild]


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Plain:
    """The build whose file is broken, without the sanitizer, which would end the process."""
    folder = tmp_path_factory.mktemp("broken")
    return lambda file: build_of(MACHINES[file], folder, sanitized=False)


def problem_of(build: HostBuild, file: str) -> str:
    if file == "programs.c":
        return programs_problem(Programs(build))
    if file == "progress.c":
        return progress_problem(Progresses(build))
    return settings_problem(Settings(build))


def is_noticed(build: HostBuild, file: str) -> bool:
    """Whether a check complains, in a process of its own, which what is broken may end."""
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGSEGV, signal.SIG_DFL)
        signal.alarm(MOST_S)
        noticed = 1  # also by what the checks cannot make sense of
        try:
            noticed = int(bool(problem_of(build, file)))
        finally:
            os._exit(noticed)
    return os.waitpid(child, 0)[1] != 0


def broken(build: HostBuild, mutant: Mutant, folder: Path) -> HostBuild:
    text = (build.project / "src" / mutant.file).read_text(encoding="utf-8")
    assert text.count(mutant.old) == 1, (
        f"{mutant.old!r} stands there {text.count(mutant.old)} times"
    )
    return build.with_changed(mutant.file, text.replace(mutant.old, mutant.new), folder)


@pytest.mark.parametrize(
    "mutant", ALL, ids=lambda mutant: f"{mutant.file}: {mutant.old} -> {mutant.new}"[:90]
)
def test_is_noticed(plain: Plain, mutant: Mutant, tmp_path: Path) -> None:
    build = broken(plain(mutant.file), mutant, tmp_path)
    assert is_noticed(build, mutant.file), "nothing notices it"


@pytest.mark.parametrize("file", MACHINES)
def test_unbroken_nothing_is_wrong(plain: Plain, file: str) -> None:
    assert problem_of(plain(file), file) == ""


def test_every_mutant_is_another_one() -> None:
    assert len(set(ALL)) == len(ALL)
