"""The line: what ends a frame, what damages one, and when nobody listens."""

from pathlib import Path

import pytest
from slave_line import CASES, Case, line_problem
from slave_world import run, ticks


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_line(slave_program: Path, case: Case) -> None:
    assert line_problem(slave_program, case) == ""


def test_the_masters_silence_is_counted_and_stays_at_its_largest(slave_program: Path) -> None:
    (state,) = run(slave_program, [ticks(60_000), ticks(60_000), b"s"])
    assert state.split()[-2:] == [b"65535", b"0"]
