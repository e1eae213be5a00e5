# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the largest stack that a program can need, from its machine code alone.

The worst case is the deepest chain of calls from reset, with the deepest interrupt on top of it. A
handler that enables interrupts can itself be interrupted: all such handlers are added, each once,
plus the deepest of the others. The result is an upper bound: no input needs more, and paths that no
input takes are included.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

from heatwright.generator.stack.flow import Analysis, Depth, Program
from heatwright.generator.stack.state import StackUnknown

_MACHINE = 0x7F  # part of the ELF header's flags that names the core
_AVR6 = 6  # more than 128 KB of flash: addresses of code take three bytes


@dataclass(frozen=True)
class WorstStack:
    """Bytes of stack that the program and its interrupts need; `total` is their sum.

    `program_chain` names the functions of the program's deepest chain of calls.
    """

    program: int
    interrupts: int
    program_chain: tuple[str, ...]

    @property
    def total(self) -> int:
        """Return the bytes of stack in the worst case."""
        return self.program + self.interrupts


def worst_stack(elf: Path) -> WorstStack:
    """Return the worst stack of the AVR program in `elf`.

    Raises StackUnknown: there is a recursion, a call by pointer, or code that moves the stack
    pointer in a way that cannot be followed.
    """
    program, handlers = _read(elf)
    analysis = Analysis(program)
    main = analysis.interrupt(0)
    interrupts = [analysis.interrupt(handler) for handler in handlers]
    return WorstStack(main.bytes, _on_top(interrupts, program.call_bytes), main.chain)


def _on_top(interrupts: list[Depth], call_bytes: int) -> int:
    """Bytes that interrupts can need on top of the program, with their return addresses."""
    yielding = sum(depth.bytes + call_bytes for depth in interrupts if depth.enables_interrupts)
    closed = [depth.bytes + call_bytes for depth in interrupts if not depth.enables_interrupts]
    return yielding + max(closed, default=0)


def _read(elf: Path) -> tuple[Program, list[int]]:
    """Return the program in `elf` and the addresses of its interrupt handlers."""
    with elf.open("rb") as file:
        image = ELFFile(file)
        text, table = image.get_section_index(".text"), image.get_section_by_name(".symtab")
        if text is None or not isinstance(table, SymbolTableSection):
            raise StackUnknown(f"{elf} has no code with names")
        code = image.get_section(text).data()
        symbols = [(symbol.name, symbol.entry) for symbol in table.iter_symbols()]
        flags = image.header["e_flags"]
    address = {name: entry["st_value"] for name, entry in symbols}
    functions = sorted(
        (entry["st_value"], entry["st_value"] + entry["st_size"], name)
        for name, entry in symbols
        if entry["st_shndx"] == text and entry["st_size"] > 0  # libgcc's have a size but no type
    )
    handlers = {value for name, value in address.items() if re.fullmatch(r"__vector_\d+", name)}
    program = Program(
        code=code,
        functions=tuple(functions),
        call_bytes=3 if flags & _MACHINE == _AVR6 else 2,
        stack_top=address["__stack"],
    )
    return program, sorted(handlers - {address.get("__bad_interrupt")})
