"""What a firmware takes at least of flash and RAM, from its spec alone.

Each figure is some 15 % below the least that was measured of its kind, whatever else the spec says:
what is over by these figures does not fit, with any compiler. What a firmware really takes,
`heatwright build` tells.
"""

from __future__ import annotations

from typing import NamedTuple

from heatwright.spec.boards import Board
from heatwright.spec.checks.memory import least_bytes
from heatwright.spec.commands import placed, tunable
from heatwright.spec.controller import Controller
from heatwright.spec.eeprom import log_entry_bytes
from heatwright.spec.interfaces import LcdKeypad, SerialLog


class Least(NamedTuple):
    """Bytes of flash, and of RAM with the stack."""

    flash: int
    ram: int


EVERY = Least(2250, 100)
"""Clock, gate, faults, settings, start-up, library; and the stack."""
TUNABLE = Least(2160, 0)
"""Of a loop whose gains a host or a master may set, and have stored."""
AUTOTUNE = Least(1670, 79)
"""Beside that."""
COUNTDOWN = Least(1090, 7)
"""Of a keypad."""
MENU = Least(4700, 140)
"""Of a keypad, where there are programs."""
PROGRAMS = Least(4300, 220)

KINDS = {
    "analog": Least(250, 5),
    "current": Least(210, 4),
    "ds18b20": Least(580, 25),
    "max31855": Least(275, 5),
    "max31856": Least(630, 30),
    "max6675": Least(225, 5),
    "rtd": Least(250, 5),
    "thermistor": Least(420, 5),
    "digital": Least(10, 0),
    "pwm": Least(90, 1),
    "stepper": Least(1400, 22),
    "time_proportional": Least(140, 5),
    "on_off": Least(940, 37),
    "pid": Least(1290, 52),
    "three_position": Least(1270, 41),
    "gcode": Least(6050, 480),
    "indicators": Least(50, 0),
    "lcd_keypad": Least(1080, 60),
    "modbus_rtu": Least(2770, 245),
    "nextion": Least(4600, 1460),
    "serial_log": Least(1800, 70),
    "serial_plotter": Least(340, 15),
}
"""By the kind of sensors, outputs, interfaces, and of an algorithm with its loop and protection."""


def least(controller: Controller) -> Least:
    """Return what the firmware takes at least, together."""
    whole = (
        *controller.sensors.values(),
        *controller.outputs.values(),
        *(loop.algorithm for loop in controller.loops.values()),
        *controller.interfaces,
    )
    parts = [EVERY, *(KINDS[each.kind] for each in whole)]
    for keypad in placed(controller, LcdKeypad).values():
        parts += [MENU] * (controller.programs is not None)
        parts += [COUNTDOWN] * (keypad.countdown is not None)
    parts += [TUNABLE for name in controller.loops if tunable(controller, name)]
    parts += [AUTOTUNE for loop in controller.loops.values() if loop.autotune is not None]
    parts += [PROGRAMS] * (controller.programs is not None)
    flash, ram = (sum(sizes) for sizes in zip(*parts, strict=True))
    return Least(flash, max(ram, least_bytes(controller)) + _rings(controller))


def _rings(controller: Controller) -> int:
    """Count the RAM of a log's entries."""
    kept = (each for each in placed(controller, SerialLog).values() if each.keep == "ram")
    return sum(each.entries * log_entry_bytes(controller, each) for each in kept)


def rooms(board: Board) -> Least:
    """Return what a board has for a firmware."""
    return Least(board.flash_bytes - board.bootloader_bytes, board.ram_bytes)


def fits(taken: Least, board: Board, spare: float = 1.0) -> bool:
    """Tell whether a board has the room, so many times."""
    return all(spare * each <= room for each, room in zip(taken, rooms(board), strict=True))
