"""Break what keeps programs and progress, one line at a time: the checks must notice."""

import os
import signal
from pathlib import Path

import pytest
from storage_mutants import ALL, Mutant
from storage_programs import Programs, programs_problem
from storage_progress import Progresses, progress_problem
from storage_specs import build_of

from heatwright.sim.host import HostBuild

MACHINE = "few"
MOST_S = 60
"""For what takes two."""


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> HostBuild:
    """Without the sanitizer, which would end the process at a mutant's first overflow."""
    return build_of(MACHINE, tmp_path_factory.mktemp("broken"), sanitized=False)


def problem_of(build: HostBuild, file: str) -> str:
    checked = Programs(build) if file == "programs.c" else Progresses(build)
    found = (
        programs_problem(checked) if isinstance(checked, Programs) else progress_problem(checked)
    )
    checked.host.close()
    return found


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
def test_is_noticed(plain: HostBuild, mutant: Mutant, tmp_path: Path) -> None:
    assert is_noticed(broken(plain, mutant, tmp_path), mutant.file), "nothing notices it"


@pytest.mark.parametrize("file", ["programs.c", "progress.c"])
def test_unbroken_nothing_is_wrong(plain: HostBuild, file: str) -> None:
    assert problem_of(plain, file) == ""


def test_every_mutant_is_another_one() -> None:
    assert len(set(ALL)) == len(ALL)
