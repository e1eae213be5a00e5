"""Firmware of every shape compiles without a warning, each file by itself, and links."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from chip import compile_and_link
from jinja2 import UndefinedError
from matrix import CHOICES, Row, can_be, pairs, pairwise, spec_of

from heatwright.generator import plan_firmware, render
from heatwright.generator.plan import File, Plan
from heatwright.spec import load_text
from heatwright.spec.controller import built_boards

Generate = Callable[..., Mapping[str, str]]
TEMPLATES = Path(__file__).parents[2] / "templates"
ROWS = pairwise()


def name_of(row: Row) -> str:
    return "-".join((row["board"], row["output"], row["algorithm"], row["interface"]))


@pytest.mark.parametrize("row", ROWS, ids=name_of)
def test_it_compiles_and_links(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = spec_of(row)
    files = generate(text)
    unused = [name for name in defined(files["src/config.h"]) if not used(name, files)]
    assert unused == []
    assert compile_and_link(files, tmp_path, load_text(text).controller.board).is_file()


def defined(config: str) -> list[str]:
    return re.findall(r"^#define (\w+) .+$", config, re.MULTILINE)


def used(name: str, files: Mapping[str, str]) -> bool:
    code = (text for path, text in files.items() if path.endswith((".c", ".h")))
    return sum(len(re.findall(rf"\b{name}\b", text)) for text in code) > 1


def test_the_rows_hold_every_choice_and_pair() -> None:
    assert set(CHOICES["board"]) == set(built_boards())
    for choice, values in CHOICES.items():
        assert {row[choice] for row in ROWS} == set(values)
    assert all(can_be(row) for row in ROWS)
    shown = frozenset().union(*map(pairs, ROWS))
    for board in CHOICES["board"]:
        for output in CHOICES["output"]:
            assert ("board", board, "output", output) in shown
    # Another draw finds no pair that could be and is not there.
    assert frozenset().union(*map(pairs, pairwise(seed=2))) == shown


def test_every_template_is_used() -> None:
    specs = [load_text(spec_of(row)) for row in ROWS]
    used_here = {file.template for spec in specs for file in plan_firmware(spec).files}
    there_are = {
        path.relative_to(TEMPLATES).as_posix()
        for path in TEMPLATES.glob("*/*")
        if path.suffix in {".c", ".h", ".j2"}
    }
    assert used_here == there_are


def test_an_undefined_name_is_an_error() -> None:
    file = File("src/clock.c", "src/clock.c.j2", {"tick_ms": 10})
    with pytest.raises(UndefinedError, match="'tick' is undefined"):
        render(Plan("name", "banner", (file,)))
