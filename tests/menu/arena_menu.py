"""The menu's C, broken, and what then has to complain: the tests of the menu."""

from pathlib import Path

import test_menu_programs
import test_menu_values
from menu_desk import CONTROLLER, MenuDesk
from rig.avr import Firmware, Program
from rig.judged import first_complaint
from rig.specs import sources_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf


def problem(program: Elf) -> str:
    """Work all screens; what starts a heater first."""
    device = AvrDevice(CONTROLLER, program)
    modules = (test_menu_programs, test_menu_values)
    return first_complaint(modules, desk=lambda: MenuDesk(device))


SOURCES = (Path(name) for name in sources_of("kiln_uno") if name.endswith(".c"))
FILES = {path.stem for path in SOURCES if path.stem.startswith("menu")} | {"panel", "keypad", "lcd"}
ARENAS = [Firmware("menu/kiln_uno", Program("kiln_uno"), tuple(sorted(FILES)), (problem,))]
