"""How long a protection may take, from the numbers of the specification alone.

P is the control period, one tick is 10 ms. A step runs in the tick in which it is due, so every
bound includes one more tick.

A reading is taken less than P before the step that uses it. A change just after a reading is seen
by the next step, at most 2 P after the change. A sensor that begins to answer badly shows this in
its next exchange, at most P later, or 2 P if an exchange was under way and still succeeds.
"""

import math

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.site import Site
from heatwright.sim.native.parts import PARTS
from heatwright.sim.reference.numbers import steps
from heatwright.spec import Controller, Loop, facts_of
from heatwright.spec.controller import WATCHDOG_S
from heatwright.spec.self_checks import FLASH_BYTES_A_TICK

TICK_S = 0.010
MAIN_PERMIT_S = 0.100
"""Time since the main loop last renewed its permit after which the gate closes."""
CYCLES_A_BIT = 24
"""Maximum time to read one byte of the EEPROM and add it to a CRC, divided by its 8 bits."""
RAM_CYCLES_A_BYTE = 100
"""Maximum time to test one byte of the RAM with its neighbour."""
FLASH_CYCLES_A_BYTE = 72
"""Maximum time to read one byte of the flash, also beyond 64 KB, and add it to a CRC."""


def reading_s(loop: Loop) -> float:
    """Return the longest time to a trip after a temperature passes a limit without a wait: 2 P."""
    return loop.periods_s(2) + TICK_S


def answer_s(loop: Loop) -> float:
    """Return the longest time to a trip after a sensor fails: STEPS(stale_after) + 1 steps."""
    return lasting_s(loop.protection.stale_after_s, loop)


def lasting_s(duration_s: float, loop: Loop) -> float:
    """Return the longest time to a trip by a lasting condition: (STEPS(duration) + 1) · P."""
    return loop.periods_s(steps(duration_s, loop) + 1) + TICK_S


def watchdog_s(site: Site) -> float:
    """Return the longest time to a trip after the main loop hangs: watchdog, then start-up."""
    turns = WATCHDOG_S.index(site.controller.safety.watchdog_s)
    shortest_s = PARTS[site.controller.board.mcu].shortest_watchdog_s
    return shortest_s * (1 << turns) + start_up_s(site)


def start_up_s(site: Site) -> float:
    """Return the time from reset to a latched fault: the EEPROM is checked, then one tick.

    A controller with self-checks first tests its RAM and flash, and waits for its watchdog where
    the bootloader allows that.
    """
    board = site.controller.board
    eeprom_s = board.eeprom_bytes * 8 * CYCLES_A_BIT / board.clock_hz
    return checks_s(site.controller, site.program) + eeprom_s + TICK_S


def checks_s(controller: Controller, program: Elf) -> float:
    """Return how much longer the start of a controller with self-checks takes, s."""
    board, waits_s = controller.board, 0.0
    if not facts_of(controller).checked:
        return waits_s
    if facts_of(controller).proves_watchdog:
        waits_s = PARTS[board.mcu].shortest_watchdog_s
    cycles = len(program.flash) * FLASH_CYCLES_A_BYTE + board.ram_bytes * RAM_CYCLES_A_BYTE
    return waits_s + cycles / board.clock_hz


def flash_s(program: Elf) -> float:
    """Return the longest time to a trip after a byte of flash changes: two rounds of the CRC."""
    ticks = math.ceil(len(program.flash) / FLASH_BYTES_A_TICK)
    return (2 * ticks + 1) * TICK_S


def gate_s() -> float:
    """Return the longest time to heaters off after the main loop hangs with interrupts on."""
    return MAIN_PERMIT_S + TICK_S
