"""Each line of the display's C that is broken is noticed by a test of its own."""

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import test_touch_hostile
import test_touch_orders
import test_touch_points
import test_touch_shows
from touch_kiln import Broken, compiled, linked
from touch_mutants import MUTANTS, Mutant

from heatwright.spec import Controller

MODULES = {
    "orders": test_touch_orders,
    "points": test_touch_points,
    "shows": test_touch_shows,
    "hostile": test_touch_hostile,
}
SHORT = {
    "orders.malformed": "a_malformed_or_impossible_order_does_nothing",
    "points.unsound": "what_is_not_sound_is_dropped_whole",
}


def noticing(mutant: Mutant) -> Callable[..., None]:
    """Find the test by the beginning of its name."""
    module, _, begins = mutant.test.partition(".")
    begins = SHORT.get(mutant.test, begins)
    found = [
        value
        for name, value in vars(MODULES[module]).items()
        if name.startswith(f"test_{begins}") and callable(value)
    ]
    assert len(found) == 1, mutant.test
    test: Callable[..., None] = found[0]
    return test


def played(test: Callable[..., None], **known: Any) -> None:
    """Run a test, with all its parameters where it has several sets of them."""
    wanted = inspect.signature(test).parameters
    given = {name: value for name, value in known.items() if name in wanted}
    marks = [mark for mark in getattr(test, "pytestmark", []) if mark.name == "parametrize"]
    if not marks:
        test(**given)
        return
    names, sets = marks[0].args
    for values in sets:
        if isinstance(names, str):
            test(**given, **{names: values})
        else:
            test(**given, **dict(zip(names, values, strict=True)))


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: f"{mutant.file}:{mutant.old[:40]}")
def test_a_broken_line_is_noticed(  # noqa: PLR0917 - fixtures
    mutant: Mutant,
    kiln_files: Mapping[str, str],
    kiln_objects: dict[str, Path],
    kiln_project: Path,
    touched: Controller,
    page_numbers: dict[str, int],
    tmp_path: Path,
) -> None:
    text = kiln_files[f"src/{mutant.file}"]
    assert text.count(mutant.old) == 1, "the line is no longer there, or there are several"
    source = tmp_path / mutant.file
    source.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
    broken = compiled(source, tmp_path, kiln_project, strict=False)
    program = linked(kiln_objects | {mutant.file: broken}, tmp_path / "kiln")
    with pytest.raises((AssertionError, Broken, KeyError, IndexError)):
        played(noticing(mutant), kiln=program, touched=touched, page_numbers=page_numbers)
