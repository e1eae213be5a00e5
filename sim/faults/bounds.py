"""How long a protection may take, from the numbers of the specification alone.

P is the control period, one tick is 10 ms. A step is done in the tick its deadline falls in, so
every bound has one tick on top.

A reading is taken less than P before the step that uses it. What changes just after that is seen by
the next step: 2 P after the change at the latest. What is wrong with the answers of a sensor shows
in the next exchange: P later at the latest, and one P more if the exchange in hand is still good.
"""

from __future__ import annotations

import math

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.site import Site
from heatwright.sim.native.parts import PARTS
from heatwright.sim.reference.numbers import steps
from heatwright.spec import Controller, Loop
from heatwright.spec.controller import WATCHDOG_S
from heatwright.spec.self_checks import FLASH_BYTES_A_TICK, proves_watchdog, self_checked

TICK_S = 0.010
MAIN_PERMIT_S = 0.100
"""Time without the main loop after which the gate closes."""
CYCLES_A_BIT = 24
"""At most, to read a byte of EEPROM and take it into a CRC, divided by its eight bits."""
RAM_CYCLES_A_BYTE = 100
"""At most, to test a cell of the RAM with its neighbour."""
FLASH_CYCLES_A_BYTE = 72
"""At most, to read a byte of the flash, also beyond 64 KB, and take it into a CRC."""


def reading_s(loop: Loop) -> float:
    """A temperature passes a limit that is judged at once: 2 P."""
    return loop.periods_s(2) + TICK_S


def answer_s(loop: Loop) -> float:
    """The sensor answers badly, or no longer: STEPS(stale_after) steps, and the one in hand."""
    return lasting_s(loop.protection.stale_after_s, loop)


def lasting_s(duration_s: float, loop: Loop) -> float:
    """Something must last: seen within 2 P, then STEPS(duration) steps, the first included."""
    return loop.periods_s(steps(duration_s, loop) + 1) + TICK_S


def watchdog_s(site: Site) -> float:
    """The main loop hangs: the watchdog's own time, then the start-up."""
    turns = WATCHDOG_S.index(site.controller.safety.watchdog_s)
    shortest_s = PARTS[site.controller.board.mcu].shortest_watchdog_s
    return shortest_s * (1 << turns) + start_up_s(site)


def start_up_s(site: Site) -> float:
    """From reset to a latched fault: EEPROM and flash are read and checked, then a tick goes by.

    A controller that checks itself goes through its RAM before, and waits for its watchdog where
    the bootloader bears it.
    """
    board = site.controller.board
    eeprom_s = board.eeprom_bytes * 8 * CYCLES_A_BIT / board.clock_hz
    return checks_s(site.controller, site.program) + eeprom_s + TICK_S


def checks_s(controller: Controller, program: Elf) -> float:
    """How much longer the start of a controller takes that checks itself."""
    board, waits_s = controller.board, 0.0
    if not self_checked(controller):
        return waits_s
    if proves_watchdog(controller):
        waits_s = PARTS[board.mcu].shortest_watchdog_s
    cycles = len(program.flash) * FLASH_CYCLES_A_BYTE + board.ram_bytes * RAM_CYCLES_A_BYTE
    return waits_s + cycles / board.clock_hz


def flash_s(program: Elf) -> float:
    """A byte of the flash changes: that round of its CRC is ended, and the next one sees it."""
    ticks = math.ceil(len(program.flash) / FLASH_BYTES_A_TICK)
    return (2 * ticks + 1) * TICK_S


def gate_s() -> float:
    """The main loop hangs with interrupts on: the gate's permit runs out."""
    return MAIN_PERMIT_S + TICK_S
