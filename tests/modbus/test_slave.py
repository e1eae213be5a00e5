"""The slave's C on this computer: against the oracle, and case by case what happens on its line."""

from collections.abc import Callable
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


@pytest.mark.parametrize("problem", [setup_problem, silence_problem])
def test_the_setup_and_the_count_of_a_silence(
    slave_program: Path, problem: Callable[[Path], str]
) -> None:
    assert problem(slave_program) == ""
