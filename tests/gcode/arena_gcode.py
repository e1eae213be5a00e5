"""The files that a G-code host speaks with, on this computer, and the judges of their mutants."""

from pathlib import Path

import test_gcode_bed
import test_gcode_commands
import test_gcode_feed
import test_gcode_flood
import test_gcode_line
import test_gcode_tools
from gcode_world import HostBoard, celsius, gcode_world, ready
from rig.hosted import InItsWorld, first_complaint


def extruder(built: Path) -> str:
    return first_complaint([test_gcode_commands, test_gcode_flood, test_gcode_line], world=built)


def feeder(built: Path) -> str:
    return first_complaint([test_gcode_feed], feeder=lambda: ready(HostBoard(built, celsius(200))))


def tools(built: Path) -> str:
    """Its chip has another interrupt, before which bytes are damaged and floods overflow."""
    problem = first_complaint([test_gcode_tools], board=lambda: test_gcode_tools.on_host(built))
    return problem or first_complaint([test_gcode_flood], world=built)


def beds(called: str) -> InItsWorld:
    def problem(built: Path) -> str:
        board = lambda: test_gcode_tools.on_host(built)  # noqa: E731 - made anew for each test
        return first_complaint([test_gcode_bed], board=board, called=called)

    spec = test_gcode_bed.spec_of(called)
    return InItsWorld(f"gcode/{called.replace(' ', '_')}", lambda: gcode_world(spec), problem)


ARENAS = [
    InItsWorld("gcode/extruder", gcode_world, extruder),
    InItsWorld("gcode/feeder", lambda: gcode_world("feeder"), feeder),
    InItsWorld("gcode/tools", lambda: gcode_world(test_gcode_tools.SPEC), tools),
    *(beds(called) for called in test_gcode_bed.CALLED),
]
