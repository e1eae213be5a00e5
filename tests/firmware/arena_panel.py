"""The chamber's panel, broken, and what then has to complain: the tests of its keys and lines."""

import test_panel
import test_start
from rig.avr import Firmware, Program
from rig.judged import first_complaint

from heatwright.sim.elf import Elf


def problem(program: Elf) -> str:
    """Work the keys of this program."""
    test_start.program = lambda: program
    return first_complaint([test_panel, test_start])


ARENAS = [Firmware("firmware/chamber", Program("chamber"), ("panel",), (problem,))]
