"""The slave's C on this computer: against the oracle, and case by case what happens on its line."""

from pathlib import Path

import pytest
from modbus_host import fuzz, played, written
from slave_line import CASES, Case, line_problem, setup_problem, silence_problem
from suite import amount

SEEDS = 4


@pytest.mark.parametrize("seed", range(SEEDS))
def test_it_answers_as_documented(slave_program: Path, seed: int) -> None:
    assert played(slave_program, written(fuzz(seed, amount("modbus_frames_host") // SEEDS))) == ""


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_line(slave_program: Path, case: Case) -> None:
    assert line_problem(slave_program, case) == ""


def test_the_masters_silence_is_counted_and_stays_at_its_largest(slave_program: Path) -> None:
    assert silence_problem(slave_program) == ""


def test_the_line_is_set_up(slave_program: Path) -> None:
    assert setup_problem(slave_program) == ""
