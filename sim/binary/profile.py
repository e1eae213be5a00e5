"""Profile where a program spends its cycles; on simavr's core one instruction at a time."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from elftools.elf.elffile import ELFFile
from numpy.typing import NDArray

from heatwright.sim.binary.elf import Elf
from heatwright.sim.native.hw import Hw, Log

ENTRY = np.dtype({"names": ["cycle", "pc"], "formats": ["<u8", "<u4"], "itemsize": 16})
NO_FUNCTION = 0xFFFF


@dataclass(frozen=True)
class FunctionProfile:
    """A function's calls and cycles: with the functions it calls (total, longest), and its own.

    Interrupts and sleep during it do not count. masked -- the longest time with interrupts off that
    began in it.
    """

    calls: int
    total: int
    longest: int
    own: int
    masked: int


@dataclass(frozen=True)
class Stretch:
    """The longest stretch of a kind: its length, when it began, and the function at its start."""

    cycles: int
    seconds: float
    began_s: float
    function: str


@dataclass(frozen=True)
class Lines:
    """Lines of a source file that have code, and those of them that were reached."""

    code: frozenset[int]
    reached: frozenset[int]

    @property
    def missed(self) -> tuple[int, ...]:
        """Lines that were never reached."""
        return tuple(sorted(self.code - self.reached))


class Profile:
    """Profiling from the moment it is made until ``stop``; see Avr.profile.

    log -- the shim's log of the entries of traced functions.
    """

    def __init__(self, hw: Hw, program: Elf) -> None:
        self._owner = hw
        self._lib, self._stopped = hw.lib, False
        self._program = program
        self.log = Log(hw, hw.lib.HW_ENTRY_LOG, ENTRY)
        self._others = np.empty(0, ENTRY)  # entries of functions that are not fetched yet
        table = self._table(hw.lib.hw_flash_size(hw.pointer))
        starts = np.array([function.start for function in program.functions], np.uint32)
        if self._lib.hw_profile_start(
            self._hw,
            hw.ffi.from_buffer("uint16_t[]", table),
            hw.ffi.from_buffer("uint32_t[]", starts),
            len(starts),
        ):
            raise ValueError("This processor is already being profiled.")

    def _table(self, flash_size: int) -> NDArray[np.uint16]:
        """Return the number of the function for each word of flash."""
        table = np.full(flash_size // 2, NO_FUNCTION, np.uint16)
        for number, function in enumerate(self._program.functions):
            table[function.start // 2 : (function.end + 1) // 2] = number
        return table

    @property
    def _hw(self) -> Any:
        if self._stopped:
            raise ValueError("This profile has been stopped: read its results before.")
        return self._owner.pointer

    def stop(self) -> None:
        """End the profile: the processor runs at full speed again. Read the results before.

        Results raise a ValueError after that; entries that were logged stay available.
        """
        self._lib.hw_profile_stop(self._hw)
        self._stopped = True

    @property
    def functions(self) -> dict[str, FunctionProfile]:
        """The functions that have run, by name."""
        table = self._lib.hw_profile_functions(self._hw)
        return {
            function.name: FunctionProfile(*_fields(table[number]))
            for number, function in enumerate(self._program.functions)
            if table[number].own
        }

    def trace(self, function: str) -> None:
        """Log each call of a function from now on: see entries. Raises ElfError: there is none."""
        number = self._program.functions.index(self._program.function(function))
        self._lib.hw_profile_trace_entry(self._hw, number, 1)

    def entries(self, function: str) -> NDArray[np.uint64]:
        """Return the cycles of a traced function's calls that have not been returned yet."""
        start = self._program.function(function).start
        found = np.concatenate([self._others, self.log.take()])
        mine = found["pc"] == start
        self._others = found[~mine]
        cycles: NDArray[np.uint64] = found["cycle"][mine]
        return cycles

    @property
    def masked(self) -> Stretch:
        """The longest time with interrupts off, once they have been on after a reset."""
        return self._stretch(self._lib.hw_profile_masked(self._hw))

    @property
    def busy(self) -> Stretch:
        """The longest stay within 8 words of code, without sleep and without interrupts."""
        return self._stretch(self._lib.hw_profile_busy(self._hw))

    def _stretch(self, found: Any) -> Stretch:
        clock = self._owner.clock_hz
        function = self._program.function_at(found.pc)
        name = function.name if function else "?"
        return Stretch(int(found.cycles), found.cycles / clock, found.at / clock, name)

    @property
    def stack_used(self) -> int:
        """Maximum number of bytes of stack in use at any time."""
        top = int(self._lib.hw_ram_end(self._hw))
        return top - int(self._lib.hw_profile_stack(self._hw))

    @property
    def reached(self) -> NDArray[np.bool_]:
        """For each word of flash, whether it has been executed."""
        words = self._lib.hw_flash_size(self._hw) // 2
        raw = self._owner.ffi.buffer(self._lib.hw_profile_coverage(self._hw), words)
        return np.frombuffer(raw, np.uint8).astype(bool)

    def lines(self) -> dict[str, Lines]:
        """Return, for each source file, its lines with code and those reached.

        An empty result means the program carries no line numbers.
        """
        reached = self.reached
        found: dict[str, tuple[set[int], set[int]]] = {}
        for start, end, file, line in line_ranges(self._program.path):
            code, hit = found.setdefault(file, (set(), set()))
            code.add(line)
            if reached[start // 2 : (end + 1) // 2].any():
                hit.add(line)
        return {file: Lines(frozenset(code), frozenset(hit)) for file, (code, hit) in found.items()}


def _fields(record: Any) -> tuple[int, int, int, int, int]:
    return record.calls, record.total, record.longest, record.own, record.masked


def line_ranges(path: Path) -> list[tuple[int, int, str, int]]:
    """Return first byte, end, file and line of each piece of code, from the line number table."""
    ranges: list[tuple[int, int, str, int]] = []
    with path.open("rb") as stream:
        elf = ELFFile(stream)
        if not elf.has_dwarf_info():
            return ranges
        info = elf.get_dwarf_info()
        for unit in info.iter_CUs():
            program = info.line_program_for_CU(unit)
            if program is not None:
                ranges += _of_program(program)
    return ranges


def _of_program(program: Any) -> list[tuple[int, int, str, int]]:
    ranges = []
    before = None
    for entry in program.get_entries():
        state = entry.state
        if state is None:
            continue
        if before is not None and state.address > before.address:
            name = program["file_entry"][before.file - 1].name.decode()
            ranges.append((before.address, state.address, name, before.line))
        before = None if state.end_sequence else state
    return ranges
