"""The menu's C, broken, and what then has to complain: the tests of the menu."""

import test_menu_programs
import test_menu_values
from menu_desk import CONTROLLER, MenuDesk
from rig.judged import OnTheBinary, first_complaint

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf


def problem(program: Elf) -> str:
    """Work all screens; what starts a heater first."""
    device = AvrDevice(CONTROLLER, program)
    modules = (test_menu_programs, test_menu_values)
    return first_complaint(modules, desk=lambda: MenuDesk(device))


ARENAS = [OnTheBinary("menu/kiln_uno", "kiln_uno", r"(menu_\w+|panel|keypad|lcd)\.c", problem)]
