"""The Modbus slave's C on this computer, judged by the oracle and by the cases of its line."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from modbus_host import Play, fuzz, played, slave_world, written
from slave_line import CASES, line_problem, setup_problem, silence_problem

SOME, MANY = 1000, 12_000
"""Frames: most mutants do not outlive the first few."""


class _Slave:
    name = "modbus/shape"
    together = True

    def __init__(self) -> None:
        self._plays: list[Play] = []

    def sources(self) -> Mapping[str, str]:
        world = slave_world()
        return {name: world.sources[name] for name in world.files}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:  # noqa: ARG002
        return slave_world().library(changed)

    def prepare(self) -> None:
        self._plays = [written(fuzz(2, SOME)), written(fuzz(1, MANY))]

    def problem(self, built: Path) -> str:
        return next(filter(None, self._problems(built)), "")

    def _problems(self, built: Path) -> Iterator[str]:
        some, many = self._plays
        yield played(built, some)
        for case in CASES:
            yield line_problem(built, case)
        yield setup_problem(built)
        yield silence_problem(built)
        yield played(built, many)


ARENAS = [_Slave()]
