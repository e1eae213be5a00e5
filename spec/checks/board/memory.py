"""A lower bound of the RAM that a firmware needs; `heatwright build` measures the real size."""

from heatwright.spec.board.eeprom import log_entry_bytes
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import keypad_of, log_of, nextion_of, placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog
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
    logs = {n: each for n, each in placed(controller, SerialLog).items() if each.keep == "ram"}
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
