"""The tests of some modules as one judge: what an arena's `problem` asks of what is broken."""

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

from rig.hosted import World

TRAPS = (
    "-fsanitize=undefined,float-cast-overflow,float-divide-by-zero",
    "-fsanitize-undefined-trap-on-error",
)
"""What C leaves undefined, such as an index behind an array, ends the judge's process."""


def first_complaint(modules: Iterable[ModuleType], **given: Any) -> str:
    """Run the tests that need nothing but what is given in place of fixtures, in their order, with
    all of their parameters, until one fails. A function is called anew for each test."""
    for module in modules:
        for test, cases in tests_of(module, set(given)):
            for case in cases:
                wanted = inspect.signature(test).parameters.keys() & given.keys()
                try:
                    test(**{name: _made(given[name]) for name in wanted}, **case)
                except Exception as error:
                    return f"{test.__name__} {case or ''}: {error!r}"[:500]
    return ""


def tests_of(
    module: ModuleType, given: set[str]
) -> Iterator[tuple[Callable[..., None], list[dict[str, Any]]]]:
    for name, test in vars(module).items():
        if name.startswith("test_") and callable(test):
            cases = list(_cases(test))
            if inspect.signature(test).parameters.keys() <= given | cases[0].keys():
                yield test, cases


def _cases(test: Callable[..., None]) -> Iterator[dict[str, Any]]:
    marks = [mark for mark in getattr(test, "pytestmark", []) if mark.name == "parametrize"]
    for values in product(*(mark.args[1] for mark in marks)):
        case: dict[str, Any] = {}
        for mark, value in zip(marks, values, strict=True):
            names = mark.args[0]
            case |= (
                {names: value} if isinstance(names, str) else dict(zip(names, value, strict=True))
            )
        yield case


def _made(given: Any) -> Any:
    return given() if inspect.isfunction(given) or inspect.ismethod(given) else given


class InItsWorld:
    """An arena: files of a firmware broken, in a world of the test's on this computer."""

    together = True

    def __init__(self, name: str, world: Callable[[], World], judge: Callable[[Path], str]) -> None:
        """Say what is broken: all files of that world; the judge says the first thing wrong."""
        self.name, self._world, self.problem = name, cache(world), judge

    def sources(self) -> Mapping[str, str]:
        """Return the files that may be broken."""
        world = self._world()
        return {name: world.sources[name] for name in world.files}

    def headers(self) -> Mapping[str, str]:
        """Return what they include."""
        sources = self._world().sources
        return {name: text for name, text in sources.items() if name.endswith(".h")}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:  # noqa: ARG002
        """Compile a library with these texts."""
        world = self._world()
        return replace(world, flags=(*world.flags, *TRAPS)).library(changed)

    def prepare(self) -> None:
        """Let the judge compute and keep what all trials share."""
        self.problem(self.build({}, Path()))
