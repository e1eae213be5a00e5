"""The slave's C against a model of it that was written from the documentation."""

from pathlib import Path

import pytest
from slave_play import fuzz, played, written


@pytest.mark.parametrize("seed", range(4))
def test_it_answers_as_documented(slave_program: Path, seed: int) -> None:
    assert played(slave_program, written(fuzz(seed, 25_000))) == ""
