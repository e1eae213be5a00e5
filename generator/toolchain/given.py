# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures a binary that was built elsewhere, in the same way as our own builds."""

import struct
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import NoteSection

from heatwright.generator.stack import StackUnknown, worst_stack
from heatwright.generator.toolchain.build import refuse_too_large
from heatwright.generator.toolchain.errors import BuildFailed
from heatwright.generator.toolchain.result import BuildResult, sizes
from heatwright.spec import Board

DEVICE = ".note.gnu.avr.deviceinfo"
"""Section in which avr-libc's start-up code names its chip (binutils: the AVR ELF ABI)."""
MEMORIES = struct.calcsize("<6I")
"""Size of the section's first part: start and size of flash, RAM and EEPROM; then come strings."""


def given(elf: Path, board: Board) -> BuildResult:
    """Measure the AVR program in `elf` for the board.

    Raises BuildFailed if its worst stack is unknown, TooLarge if it does not fit.
    """
    flash, ram = sizes(elf)
    try:
        stack = worst_stack(elf).total
    except StackUnknown as reason:
        raise BuildFailed(f"{elf}: the worst stack is unknown: {reason}.") from reason
    room = board.flash_bytes - board.bootloader_bytes
    built = BuildResult(elf, flash, ram, stack, room, board.ram_bytes, log="")
    refuse_too_large(built, elf)
    return built


def refuse_other_chip(elf: Path, board: Board) -> None:
    """Raise BuildFailed if the AVR program in `elf` was linked for another chip."""
    chip = chip_of(elf)
    if chip not in {"", board.mcu}:
        raise BuildFailed(f"{elf} was built for the {chip}; the spec's chip is the {board.mcu}.")


def chip_of(elf: Path) -> str:
    """Return the chip that a program was linked for, or nothing if it has no name of a chip."""
    with elf.open("rb") as file:
        section = ELFFile(file).get_section_by_name(DEVICE)
        notes = list(section.iter_notes()) if isinstance(section, NoteSection) else []
    if not notes:
        return ""
    told: bytes = notes[0]["n_descdata"]
    (offsets,) = struct.unpack_from("<I", told, MEMORIES)
    (name,) = struct.unpack_from("<I", told, MEMORIES + 4)
    strings = told[MEMORIES + offsets :]
    return strings[name:].partition(b"\0")[0].decode("ascii", "replace").lower()
