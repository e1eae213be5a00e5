"""Break the slave's C in many ways, one at a time: the model and the line's cases must notice."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pytest
from slave_line import CASES, line_problem
from slave_mutants import MUTANTS, SlaveMutant
from slave_play import Play, fuzz, played, written
from slave_world import WORLD, compiled, linked, run, ticks, write_sources


@pytest.fixture(scope="session")
def play() -> Play:
    return written(fuzz(1, 12_000))


class Whole(NamedTuple):
    """The slave as it should be, file by file."""

    folder: Path
    objects: dict[str, Path]


@pytest.fixture(scope="session")
def whole(slave_files: Mapping[str, str], tmp_path_factory: pytest.TempPathFactory) -> Whole:
    folder = tmp_path_factory.mktemp("mutants")
    sources = [*write_sources(slave_files, folder), WORLD]
    objects = compiled(sources, folder, folder / "objects", "-w")
    return Whole(folder, {each.name: made for each, made in zip(sources, objects, strict=True)})


def problem_of(program: Path, play: Play) -> str:
    """Say what is wrong with a slave; an empty text if nothing is."""
    try:
        problem = played(program, play)
        for case in CASES:
            problem = problem or line_problem(program, case)
        (state,) = run(program, [ticks(60_000), ticks(60_000), b"s"])
    except AssertionError as wrong:
        return str(wrong) or "it does not run"
    return problem or ("" if state.split()[-2] == b"65535" else "the silence wraps")


def broken(mutant: SlaveMutant, whole: Whole, number: int) -> Path:
    text = (whole.folder / "src" / mutant.file).read_text(encoding="utf-8")
    found = text.count(mutant.old)
    assert found == 1, f"{mutant.old!r} stands there {found} times"
    changed = whole.folder / f"mutant{number}" / mutant.file
    changed.parent.mkdir()
    changed.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
    (made,) = compiled([changed], whole.folder, changed.parent, "-w")
    objects = {**whole.objects, mutant.file: made}
    return linked(objects.values(), changed.parent / "world")


@pytest.mark.parametrize("number", range(len(MUTANTS)), ids=[each.name for each in MUTANTS])
def test_is_noticed(number: int, whole: Whole, play: Play) -> None:
    assert problem_of(broken(MUTANTS[number], whole, number), play), "nothing notices it"


def test_unbroken_nothing_is_wrong(slave_program: Path, play: Play) -> None:
    assert problem_of(slave_program, play) == ""


def test_every_mutant_is_another_one() -> None:
    assert len(set(MUTANTS)) == len(MUTANTS) >= 150
