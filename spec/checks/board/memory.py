"""Lower bounds of the flash and RAM that a firmware needs, computed from its spec alone.

`heatwright build` measures the real sizes.
"""

from heatwright.spec.base import Least
from heatwright.spec.board.serial_log import log_entry_bytes, logs_in_ram
from heatwright.spec.boards import Board
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import keypad_of, log_of, nextion_of, tunable
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import number

# RAM of the smallest firmware, and of each addition to it. Each value is a little less than was
# measured, so that a firmware which fits is never refused.
LEAST_BYTES = 200
NEXTION_BYTES = 1700
PROGRAMS_BYTES = 240
POINT_BYTES = 27
POINT_SHOWN_BYTES = 36
"""RAM for each point of a program that a nextion display shows."""
MENU_BYTES = 150
LOG_BYTES = 60


def least_bytes(controller: Controller) -> int:
    """Return the least RAM that a firmware needs, without the ring buffer of a log."""
    programs = controller.programs
    touched = nextion_of(controller) is not None
    found = LEAST_BYTES + NEXTION_BYTES * touched
    found += LOG_BYTES * (log_of(controller) is not None)
    if programs is None:
        return found
    found += MENU_BYTES * (keypad_of(controller) is not None)
    return found + PROGRAMS_BYTES + programs.points * (POINT_BYTES + POINT_SHOWN_BYTES * touched)


def ram_suffices(controller: Controller) -> Findings:
    """Find logs, displays and programs that the chip has no RAM for."""
    board, least = controller.board, least_bytes(controller)
    logs = logs_in_ram(controller)
    entry_bytes = {index: log_entry_bytes(controller, each) for index, each in logs.items()}
    rings = {index: each.entries * entry_bytes[index] for index, each in logs.items()}
    because_of: tuple[Path, ...] = (("controller", "board"), ("programs",), ("interfaces",))
    has = f"and the {board.mcu} has {board.ram_bytes}"
    display = nextion_of(controller)
    if display is not None and least > board.ram_bytes:
        kept = " and programs" if controller.programs is not None else ""
        yield Finding(
            ("interfaces", controller.interfaces.index(display), "kind"),
            f"with a nextion{kept} the firmware needs at least {least} bytes of RAM, {has}: "
            f"{least - board.ram_bytes} too many",
            "Use a board with more RAM, such as mega2560, or an lcd_keypad instead",
            because_of,
        )
    elif rings and least + max(rings.values()) > board.ram_bytes:
        index = max(rings, key=rings.__getitem__)
        most = (board.ram_bytes - least) // entry_bytes[index]
        yield Finding(
            ("interfaces", index, "entries"),
            f"entries need {number(rings[index])} bytes of RAM, the rest at least {least}, {has}: "
            f"{least + rings[index] - board.ram_bytes} too many",
            f"Use at most {most}, or keep: eeprom" if most else "Use keep: eeprom",
            because_of,
        )


# Each figure, here and of each kind (`least` of its model), is some 15 % below the lowest measured
# value: a firmware that is too large by these figures is too large with any compiler.
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
    if (keypad := keypad_of(controller)) is not None:
        parts += [MENU] * (controller.programs is not None)
        parts += [COUNTDOWN] * (keypad.countdown is not None)
    parts += [TUNABLE for name in controller.loops if tunable(controller, name)]
    parts += [AUTOTUNE for loop in controller.loops.values() if loop.autotune is not None]
    parts += [PROGRAMS] * (controller.programs is not None)
    parts += [SELF_CHECKS] * controller.safety.self_checks
    flash, ram = (sum(sizes) for sizes in zip(*parts, strict=True))
    return Least(flash, max(ram, least_bytes(controller)) + _rings(controller))


def _rings(controller: Controller) -> int:
    """Count the bytes of the logs' entries that are kept in RAM."""
    logs = logs_in_ram(controller).values()
    return sum(each.entries * log_entry_bytes(controller, each) for each in logs)


def rooms(board: Board) -> Least:
    """Return the flash and RAM that a board has for a firmware."""
    return Least(board.flash_bytes - board.bootloader_bytes, board.ram_bytes)


def fits(taken: Least, board: Board, spare: float = 1.0) -> bool:
    """Return whether a board has at least `spare` times the memory that is needed."""
    return all(spare * each <= room for each, room in zip(taken, rooms(board), strict=True))
