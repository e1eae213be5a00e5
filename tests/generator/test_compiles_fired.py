"""Firmware with programs, displays, logs and a relay compiles in every shape, too."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from chip import compile_and_link
from fired import CHOICES, can_be, pairs, pairwise, spec_of
from matrix import Row
from test_compiles import defined, used

from heatwright.spec import load_text

Generate = Callable[..., Mapping[str, str]]
ROWS = pairwise()


@pytest.mark.parametrize(
    "row", ROWS, ids=lambda row: f"{row['board']}-{row['display']}-{row['programs']}-{row['log']}"
)
def test_it_compiles_and_links(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = spec_of(row)
    files = generate(text)
    assert [name for name in defined(files["src/config.h"]) if not used(name, files)] == []
    assert compile_and_link(files, tmp_path, load_text(text).controller.board).is_file()


def test_the_rows_hold_every_choice_and_pair() -> None:
    for choice, values in CHOICES.items():
        assert {row[choice] for row in ROWS} == set(values)
    assert all(can_be(row) for row in ROWS)
    # Another draw finds no pair that could be and is not there.
    shown = frozenset().union(*map(pairs, ROWS))
    assert frozenset().union(*map(pairs, pairwise(seed=2))) == shown
