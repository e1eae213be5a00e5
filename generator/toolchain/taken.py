# SPDX-License-Identifier: GPL-3.0-or-later
"""The flash and RAM that each source file of a program takes."""

from collections import defaultdict
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from elftools.dwarf.compileunit import CompileUnit
from elftools.dwarf.die import DIE
from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from heatwright.generator.toolchain.result import FLASH, RAM, sizes

ADDRESS = 0x03
"""DW_OP_addr: the variable is at a fixed address, which follows."""


class Bytes(NamedTuple):
    """Bytes of flash and of static RAM; variables with an initial value take both."""

    flash: int
    ram: int

    def __add__(self, other: tuple[int, ...]) -> "Bytes":  # type: ignore[override]
        """Add flash to flash, and RAM to RAM."""
        flash, ram = other
        return Bytes(self.flash + flash, self.ram + ram)


NONE = Bytes(0, 0)


def taken(elf: Path) -> dict[str, Bytes]:
    """Return the bytes of each source file, by its name without folders; the sum is the program.

    Bytes of no source file (the C library, the start-up, constants without a name) have the name
    "".
    """
    found: defaultdict[str, Bytes] = defaultdict(lambda: NONE)
    with elf.open("rb") as file:
        image = ELFFile(file)
        sources = _sources(image)
        for address, (section, size) in _symbols(image).items():
            found[sources.get(address, "")] += (size * (section in FLASH), size * (section in RAM))
    flash, ram = sizes(elf)
    named = sum((each for name, each in found.items() if name), NONE)
    return {**found, "": Bytes(flash - named.flash, ram - named.ram)}


def _symbols(image: ELFFile) -> dict[int, tuple[str, int]]:
    """Find the section and size of each symbol, by address: each address is counted once."""
    table = image.get_section_by_name(".symtab")
    names = [section.name for section in image.iter_sections()]
    if not isinstance(table, SymbolTableSection):
        return {}
    return {
        symbol["st_value"]: (names[symbol["st_shndx"]], symbol["st_size"])
        for symbol in table.iter_symbols()
        if symbol["st_size"] > 0 and isinstance(symbol["st_shndx"], int)
    }


def _sources(image: ELFFile) -> dict[int, str]:
    """Find the file that each function and variable comes from, by address."""
    if not image.has_dwarf_info():
        return {}
    found: dict[int, str] = {}
    for unit in image.get_dwarf_info().iter_CUs():
        name = _file(unit)
        for die in unit.iter_DIEs():
            address = _address(die)
            if address is not None:
                found[address] = name
    return found


def _file(unit: CompileUnit) -> str:
    """Return the file name of a compilation unit; some units of the library have none."""
    name = unit.get_top_DIE().attributes.get("DW_AT_name")
    text = "" if name is None else name.value.decode("utf-8", "replace")
    return PurePosixPath(text.replace("\\", "/")).name


def _address(die: DIE) -> int | None:
    """Return the address of a function or variable; None if it has none."""
    if die.tag == "DW_TAG_subprogram" and "DW_AT_low_pc" in die.attributes:
        return int(die.attributes["DW_AT_low_pc"].value)
    if die.tag != "DW_TAG_variable" or "DW_AT_location" not in die.attributes:
        return None
    location = die.attributes["DW_AT_location"].value
    if isinstance(location, list) and location and location[0] == ADDRESS:
        return int.from_bytes(bytes(location[1:]), "little")
    return None
