"""Firmware with programs, displays, logs and a relay compiles in every shape, too."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from chip import compile_and_link
from elftools.elf.elffile import ELFFile
from fired import CHOICES, can_be, pairs, pairwise, spec_of
from matrix import Row
from test_compiles import defined, used

from heatwright.generator.stack import worst_stack
from heatwright.spec import Controller, SerialLog, load_text
from heatwright.spec.checks.memory import ENTRY_BYTES, least_bytes

Generate = Callable[..., Mapping[str, str]]
ROWS = pairwise()


def static_bytes(elf: Path) -> int:
    """Bytes of variables."""
    with elf.open("rb") as file:
        found = [ELFFile(file).get_section_by_name(name) for name in (".data", ".bss", ".noinit")]
        return sum(section["sh_size"] for section in found if section is not None)


def ring_bytes(controller: Controller) -> int:
    """Bytes of a log in RAM."""
    logs = [each for each in controller.interfaces if isinstance(each, SerialLog)]
    return sum(ENTRY_BYTES * each.entries for each in logs if each.keep == "ram")


@pytest.mark.parametrize(
    "row", ROWS, ids=lambda row: f"{row['board']}-{row['display']}-{row['programs']}-{row['log']}"
)
def test_it_compiles_and_links(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = spec_of(row)
    files = generate(text)
    assert [name for name in defined(files["src/config.h"]) if not used(name, files)] == []
    controller = load_text(text).controller
    elf = compile_and_link(files, tmp_path, controller.board)
    needed = least_bytes(controller) + ring_bytes(controller)  # the check of RAM refuses no less
    assert needed <= static_bytes(elf) + worst_stack(elf).total


def test_the_rows_hold_every_choice_and_pair() -> None:
    for choice, values in CHOICES.items():
        assert {row[choice] for row in ROWS} == set(values)
    assert all(can_be(row) for row in ROWS)
    # Another draw finds no pair that could be and is not there.
    shown = frozenset().union(*map(pairs, ROWS))
    assert frozenset().union(*map(pairs, pairwise(seed=2))) == shown
