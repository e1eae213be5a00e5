"""A linked AVR program: its flash image, its symbols, its functions.

Addresses are the processor's: flash in bytes from 0, RAM as in the data sheet (without the ELF
file's offsets 0x800000 for RAM and 0x810000 for EEPROM).
"""

import bisect
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elftools.common.exceptions import ELFError
from elftools.elf.elffile import ELFFile

RAM = 0x800000
EEPROM = 0x810000
FUSES = 0x820000


class ElfError(ValueError):
    """The file is not a linked AVR program, or lacks a requested symbol; see the message."""


@dataclass(frozen=True, order=True)
class Function:
    """A function: flash bytes start to end (exclusive)."""

    start: int
    end: int
    name: str


class Elf:
    """A linked program, read once.

    flash -- image from address 0; eeprom -- initial contents, or empty; symbols -- name to address
    (RAM and EEPROM without their offset); functions -- in order of address; static_ram -- first and
    one past the last byte of .data, .bss and .noinit. Raises ElfError: the file cannot be read as
    an AVR program.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        try:
            with self.path.open("rb") as stream:
                self._read(ELFFile(stream))
        except ELFError as error:
            raise ElfError(f"{self.path} is not an ELF file ({error}).") from error

    def _read(self, elf: Any) -> None:
        if elf["e_machine"] != "EM_AVR" or elf["e_type"] != "ET_EXEC":
            raise ElfError(f"{self.path} is not a linked AVR program.")
        self.flash, self.eeprom = _images(elf)
        symbols = _symbols(elf)
        self.symbols = {name: _without_offset(address) for name, address, _ in symbols}
        self._sizes = _sizes(elf)
        self.functions = _functions(elf, symbols)
        self.static_ram = _static_ram(elf)
        self._starts = [function.start for function in self.functions]

    def function_at(self, address: int) -> Function | None:
        """Return the function that contains the flash byte, or None."""
        place = bisect.bisect_right(self._starts, address) - 1
        found = self.functions[place] if place >= 0 else None
        return found if found and address < found.end else None

    def function(self, name: str) -> Function:
        """Return the function of that name. Raises ElfError: there is none."""
        for function in self.functions:
            if function.name == name:
                return function
        raise ElfError(f"{self.path.name} has no function {name}.")

    def size_of(self, symbol: str) -> int:
        """Return how many bytes a variable or constant takes. Raises ElfError: there is none."""
        if symbol not in self._sizes:
            raise ElfError(f"{self.path.name} has no variable {symbol}.")
        return self._sizes[symbol]

    def flash_bytes(self, symbol: str, size: int) -> bytes:
        """Return size bytes of a constant in flash. Raises ElfError: it is not there."""
        address = self.symbols.get(symbol)
        if address is None or address + size > len(self.flash):
            raise ElfError(f"{self.path.name} has no constant {symbol} in flash.")
        return self.flash[address : address + size]


def _sizes(elf: Any) -> dict[str, int]:
    table = elf.get_section_by_name(".symtab")
    symbols = table.iter_symbols() if table else ()
    return {symbol.name: symbol["st_size"] for symbol in symbols if symbol["st_size"]}


def _without_offset(address: int) -> int:
    for offset in (EEPROM, RAM):
        if address >= offset:
            return address - offset
    return address


def _images(elf: Any) -> tuple[bytes, bytes]:
    flash, eeprom = bytearray(), bytearray()
    for segment in elf.iter_segments("PT_LOAD"):
        address = segment["p_paddr"]
        if not segment["p_filesz"] or address >= FUSES:
            continue
        image, start = (eeprom, address - EEPROM) if address >= EEPROM else (flash, address)
        if start >= RAM:
            continue
        image.extend(b"\xff" * (start + segment["p_filesz"] - len(image)))
        image[start : start + segment["p_filesz"]] = segment.data()
    return bytes(flash), bytes(eeprom)


def _symbols(elf: Any) -> list[tuple[str, int, str]]:
    table = elf.get_section_by_name(".symtab")
    if table is None:
        return []
    return [
        (symbol.name, symbol["st_value"], symbol["st_info"]["type"])
        for symbol in table.iter_symbols()
        if symbol.name and isinstance(symbol["st_shndx"], int)  # defined in a section
    ]


def _functions(elf: Any, symbols: list[tuple[str, int, str]]) -> tuple[Function, ...]:
    """Return functions that each end at the next: the library's assembler code has no sizes."""
    text = elf.get_section_by_name(".text")
    if text is None:
        return ()
    first, end = text["sh_addr"], text["sh_addr"] + text["sh_size"]
    names: dict[int, tuple[bool, bool, str]] = {}
    for name, address, kind in symbols:
        if first <= address < end and not name.startswith(".") and kind in _CODE:
            key = (kind != "STT_FUNC", name.startswith("__vector_"), name)
            names[address] = min(names.get(address, key), key)
    starts = sorted(names)
    ends = [*starts, end][1:]
    return tuple(
        Function(start, stop, names[start][2]) for start, stop in zip(starts, ends, strict=True)
    )


_CODE = {"STT_FUNC", "STT_NOTYPE"}


def _static_ram(elf: Any) -> tuple[int, int]:
    inside = [
        (section["sh_addr"] - RAM, section["sh_addr"] - RAM + section["sh_size"])
        for section in elf.iter_sections()
        if RAM <= section["sh_addr"] < EEPROM and section["sh_size"]
    ]
    if not inside:
        return 0, 0
    return min(start for start, _ in inside), max(end for _, end in inside)
