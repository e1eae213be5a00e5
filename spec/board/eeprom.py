"""The areas of the EEPROM, and how long its cells last.

The areas follow each other from address 0: settings, programs, progress of the program, log. Slots
of settings begin at multiples of 64 bytes in every firmware.
"""

import math
from typing import NamedTuple

from heatwright.spec.adjusted import numbers_of
from heatwright.spec.board.serial_log import log_entry_bytes, log_in_eeprom
from heatwright.spec.commands import tunable
from heatwright.spec.controller import Controller

CELL_WRITES = 100_000
"""Endurance of an EEPROM cell, AVR data sheets, section "Features"."""
YEAR_S = 365.25 * 86_400.0
LEAST_YEARS = 10.0
"""Time that the cells must last while a log is written, or a program runs day and night."""

SETTINGS_SLOT_BYTES = 64
"""A slot's size is a multiple of this, so that another firmware finds where each slot begins."""
RECORD_BYTES = 2 + 1 + 4 + 2 + 10
"""Bytes of a record besides settings and trip count: CRC, size, digest, sequence number, fault."""
MOST_RECORD_BYTES = 255
"""Maximum size of a record: its size and the number of the next byte each fit into one byte."""
MOST_SETTINGS_SLOTS = 16
"""Maximum number of slots. The start checks each, 64 bytes in at most 0.6 ms at 8 MHz: well within
the shortest watchdog period of 30 ms."""
CYCLES_A_BYTE = 75
"""Maximum number of cycles to read a byte and add it to a CRC: at 8 MHz 64 bytes take 0.6 ms."""
FEWEST_SETTINGS_SLOTS = 4
"""Minimum number of slots if programs or a log need room: they last for 400 000 saves, 100 a
day for 10 years."""

PROGRAM_BYTES = 12 + 1 + 1
"""Bytes of a program without its segments: name with its end, number of segments."""
SEGMENT_BYTES = 1 + 2 + 4
"""Bytes of a segment: kind, target, amount."""
PROGRAM_FRAME_BYTES = 1 + 2 + 1
"""Bytes around a stored program: turn (a counter of its writes), CRC, turn again."""
SLOTS_OF_A_PROGRAM = 2

PROGRESS_BYTES = 4 + (4 + 2 + 4 * 4 + 4 * 4) + 2 + 1
"""Bytes of a slot: sequence number; state, number, segment, end; CRC of the program; four
temperatures; four counts; CRC, and the sequence number's lowest byte again."""
FEWEST_PROGRESS_SLOTS = 2
MOST_PROGRESS_SLOTS = 255
"""Maximum number of slots: the lowest byte of a slot's sequence number differs in each round."""

LOG_FRAME_BYTES = 2 + 1 + 1
"""Bytes that show whether a log entry is complete: turn, digest, turn again."""


class Area(NamedTuple):
    """Slots of the same size, one after the other."""

    start: int
    slot_bytes: int
    slots: int

    @property
    def end(self) -> int:
        """Address of the first byte after the area."""
        return self.start + self.slot_bytes * self.slots

    def years(self, every_s: float) -> float:
        """Return how many years the cells last if a slot is written every `every_s`, in turn."""
        return self.slots * CELL_WRITES * every_s / YEAR_S


class Layout(NamedTuple):
    """The areas of the EEPROM; an unused area has no slots."""

    settings: Area
    programs: Area
    progress: Area
    history: Area

    @property
    def end(self) -> int:
        """Address of the first unused byte; beyond the EEPROM if that is too small."""
        return self.history.end


def settings_bytes(controller: Controller) -> int:
    """Count the bytes of a record of settings: setpoints, maxima, gains, limits, numbers, types."""
    kept = sum(
        4 * loop.setpoint.stored
        + 4 * loop.protection.maximum_adjustable
        + 12 * tunable(controller, name)
        + 12 * loop.algorithm.limits_adjustable
        + 4 * len(numbers_of(controller, name))
        for name, loop in controller.loops.items()
    )
    return (
        RECORD_BYTES
        + (controller.lockout is not None)
        + kept
        + sum(bool(each.selectable) for each in controller.thermometers.values())
    )


def layout(controller: Controller) -> Layout:
    """Lay out the EEPROM; it may be too small (`Layout.end`)."""
    slot_bytes = -(-settings_bytes(controller) // SETTINGS_SLOT_BYTES) * SETTINGS_SLOT_BYTES
    room = controller.board.eeprom_bytes
    programs_bytes, places = _programs(controller)
    log = log_in_eeprom(controller)
    entries = log.entries if log else 0
    entry_bytes = LOG_FRAME_BYTES + log_entry_bytes(controller, log) if log else 0
    room -= places * programs_bytes + entries * entry_bytes
    save_every_s = controller.programs.save_every_s if controller.programs else math.inf
    needed = math.ceil(LEAST_YEARS * YEAR_S / (CELL_WRITES * save_every_s))
    lasting = max(FEWEST_PROGRESS_SLOTS, needed)
    wanted = lasting * PROGRESS_BYTES if places else 0
    most = room // slot_bytes
    if places or entries:
        most = max(FEWEST_SETTINGS_SLOTS, (room - wanted) // slot_bytes)
    settings = Area(0, slot_bytes, min(MOST_SETTINGS_SLOTS, most))
    left = (room - settings.end) // PROGRESS_BYTES if places else 0
    slots = min(MOST_PROGRESS_SLOTS, max(FEWEST_PROGRESS_SLOTS, left)) if places else 0
    programs = Area(settings.end, programs_bytes, places)
    progress = Area(programs.end, PROGRESS_BYTES, slots)
    return Layout(settings, programs, progress, Area(progress.end, entry_bytes, entries))


def start_s(controller: Controller) -> float:
    """Return the time that the start takes to find the newest settings and progress, at most, s."""
    areas = layout(controller)
    checked = areas.settings.end + areas.progress.end - areas.progress.start
    return checked * CYCLES_A_BYTE / controller.board.clock_hz


def _programs(controller: Controller) -> tuple[int, int]:
    """Return the bytes of a program's slot, and the number of slots."""
    if controller.programs is None:
        return 0, 0
    body = PROGRAM_BYTES + SEGMENT_BYTES * controller.programs.points
    return PROGRAM_FRAME_BYTES + body, SLOTS_OF_A_PROGRAM * controller.programs.places


def slowest_s(years: float, slots: int) -> float:
    """Return the shortest interval between writes with which the slots last for `years`, s."""
    return years * YEAR_S / (CELL_WRITES * slots)
