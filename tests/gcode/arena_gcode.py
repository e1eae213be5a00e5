"""The files that a G-code host speaks with, on this computer, and the judges of their mutants."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import test_gcode_commands
import test_gcode_feed
import test_gcode_line
import test_gcode_tools
from gcode_world import HostBoard, celsius, gcode_world
from rig.hosted import World
from rig.judged import first_complaint
from test_gcode_noise import session_problem

SESSIONS = 4


class _Host:
    together = True

    def __init__(self, name: str, spec: str, *flags: str) -> None:
        self.name = f"gcode/{name}"
        self._spec = spec, *flags

    @cached_property
    def _world(self) -> World:
        return gcode_world(*self._spec)

    def sources(self) -> Mapping[str, str]:
        return {name: self._world.sources[name] for name in self._world.files}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:  # noqa: ARG002
        return self._world.library(changed)

    def prepare(self) -> None:
        pass


class _Extruder(_Host):
    def problem(self, built: Path) -> str:
        problem = first_complaint([test_gcode_commands, test_gcode_line], world=built)
        sessions = (session_problem(built, seed) for seed in range(SESSIONS))
        return problem or next(filter(None, sessions), "")


class _Feeder(_Host):
    def problem(self, built: Path) -> str:
        def feeder() -> HostBoard:
            board = HostBoard(built, celsius(200))
            assert board.told("M104 S200", 1.0) == ["ok"]
            return board

        return first_complaint([test_gcode_feed], feeder=feeder)


class _Tools(_Host):
    def problem(self, built: Path) -> str:
        def board() -> HostBoard:
            return HostBoard(built, celsius(30), celsius(20, "bed"))

        return first_complaint([test_gcode_tools], board=board)


ARENAS = [
    _Extruder("extruder", "extruder"),
    _Feeder("feeder", "feeder"),
    _Tools("tools", test_gcode_tools.SPEC),
]
