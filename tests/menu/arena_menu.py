"""The menu's C, broken, and what then has to complain: the tests of the menu."""

from pathlib import Path

import test_menu
from menu_desk import CONTROLLER, MenuDesk
from rig.avr import Firmware, Program
from rig.judged import first_complaint
from rig.specs import sources_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf


def problem(program: Elf) -> str:
    """Work all screens."""
    device = AvrDevice(CONTROLLER, program)
    return first_complaint([test_menu], desk=lambda: MenuDesk(device))


SOURCES = (Path(name) for name in sources_of("kiln_uno") if name.endswith(".c"))
FILES = {path.stem for path in SOURCES if path.stem.startswith("menu")} | {"panel", "keypad", "lcd"}
ARENAS = [Firmware("menu/kiln_uno", Program("kiln_uno"), tuple(sorted(FILES)), (problem,))]
