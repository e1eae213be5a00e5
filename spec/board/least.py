"""Lower bounds of the flash and RAM that a firmware needs, computed from its spec alone.

Each figure, here and of each kind (`least` of its model), is some 15 % below the lowest measured
value: a firmware that is too large by these figures is too large with any compiler. `heatwright
build` measures the real sizes.
"""

from heatwright.spec.base import Least
from heatwright.spec.board.eeprom import log_entry_bytes
from heatwright.spec.boards import Board
from heatwright.spec.checks.board.memory import least_bytes
from heatwright.spec.commands import placed, tunable
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import LcdKeypad, SerialLog
from heatwright.spec.self_checks import self_checked

EVERY = Least(2250, 100)
"""Memory of every firmware: clock, gate, faults, settings, start-up, library; and the stack."""
TUNABLE = Least(2160, 0)
"""Memory for each loop whose gains a host, a master, a touch display or a menu may set."""
AUTOTUNE = Least(1670, 79)
"""Memory for each loop with autotune, in addition to TUNABLE."""
COUNTDOWN = Least(1090, 7)
"""Memory for the countdown of a keypad."""
MENU = Least(4700, 140)
"""Memory for the menu of a keypad, if the controller has programs."""
PROGRAMS = Least(4300, 220)
SELF_CHECKS = Least(650, 12)


def least(controller: Controller) -> Least:
    """Return the least flash and RAM that the whole firmware needs."""
    whole = (
        *controller.sensors.values(),
        *controller.outputs.values(),
        *(loop.algorithm for loop in controller.loops.values()),
        *controller.interfaces,
    )
    parts = [EVERY, *(each.least for each in whole)]
    for keypad in placed(controller, LcdKeypad).values():
        parts += [MENU] * (controller.programs is not None)
        parts += [COUNTDOWN] * (keypad.countdown is not None)
    parts += [TUNABLE for name in controller.loops if tunable(controller, name)]
    parts += [AUTOTUNE for loop in controller.loops.values() if loop.autotune is not None]
    parts += [PROGRAMS] * (controller.programs is not None)
    parts += [SELF_CHECKS] * self_checked(controller)
    flash, ram = (sum(sizes) for sizes in zip(*parts, strict=True))
    return Least(flash, max(ram, least_bytes(controller)) + _rings(controller))


def _rings(controller: Controller) -> int:
    """Count the bytes of the logs' entries that are kept in RAM."""
    kept = (each for each in placed(controller, SerialLog).values() if each.keep == "ram")
    return sum(each.entries * log_entry_bytes(controller, each) for each in kept)


def rooms(board: Board) -> Least:
    """Return the flash and RAM that a board has for a firmware."""
    return Least(board.flash_bytes - board.bootloader_bytes, board.ram_bytes)


def fits(taken: Least, board: Board, spare: float = 1.0) -> bool:
    """Return whether a board has at least `spare` times the memory that is needed."""
    return all(spare * each <= room for each, room in zip(taken, rooms(board), strict=True))
