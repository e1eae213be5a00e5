"""C for the simulated processor: small programs, parts of a firmware with a `main` of the test's,
and whole firmware. Each is compiled once (`store`)."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rig.specs import example, sources_of, spec_of
from rig.store import made

from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.elf import Elf
from heatwright.spec import Board as BoardData

CLOCK_HZ = 16_000_000
SHARED = Path(__file__).parents[1] / "sim_native" / "firmware"
PRELUDE = """
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <stdbool.h>
#include <stdint.h>
#include <util/delay.h>
"""
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
FLAGS = ("-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections",
         "-fdata-sections")  # fmt: skip
Changed = Mapping[str, str]
"""Files of a firmware, by name, that have another text: a mutant is compiled without warnings."""


def compiled(source: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile a small program; the usual headers are included."""
    command = ["avr-gcc", f"-mmcu={mcu}", f"-DF_CPU={CLOCK_HZ}UL", "-Os"]
    command += [] if any(flag.startswith("-g") for flag in flags) else ["-gdwarf-2"]
    command += ["-std=gnu11", "-Wall", "-Wno-unused-function", *flags, "test.c", "-o", "test.elf"]
    text = f'{PRELUDE}\n#line 1 "test.c"\n{source}'
    return Elf(made(command, {"test.c": text}, "test.elf"))


def shared(name: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile one of the files in tests/sim_native/firmware."""
    return compiled((SHARED / name).read_text("utf-8"), *flags, mcu=mcu)


def powered(program: Elf, mcu: str = "atmega328p") -> Avr:
    """Return a processor with the program, at cycle 0."""
    avr = Avr(mcu, CLOCK_HZ)
    avr.load(program)
    return avr


def running(source: str, *flags: str, mcu: str = "atmega328p") -> Avr:
    """Return a processor at cycle 0 with this C as its program."""
    return powered(compiled(source, *flags, mcu=mcu), mcu)


def part(
    spec: str, names: Iterable[str], main: str, *flags: str, changed: Changed | None = None
) -> Elf:
    """Compile some files of a spec's firmware with a main program, strictly.

    Args:
        spec: the text of the spec, or the name of an example.
        names: the files, without their ending.
        main: the text of main.c.
        flags: more flags of the compiler.
        changed: files with another text.

    """
    sources = sources_of(spec)
    headers = {name: text for name, text in sources.items() if name.endswith(".h")}
    chosen = {f"{name}.c": sources[f"{name}.c"] for name in names} | {"main.c": main}
    return _linked(spec, headers | chosen | dict(changed or {}), chosen, flags, bool(changed))


def whole(spec: str, *flags: str, changed: Changed | None = None) -> Elf:
    """Compile the whole firmware of a spec (its text, or the name of an example)."""
    sources = sources_of(spec)
    files = [name for name in sources if name.endswith(".c")]
    return _linked(spec, sources | dict(changed or {}), files, flags, bool(changed))


def _linked(
    spec: str, texts: Mapping[str, str], files: Iterable[str], flags: Iterable[str], broken: bool
) -> Elf:
    board = board_of(spec)
    chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL"]
    headers = {name: text for name, text in texts.items() if name.endswith(".h")}
    words = ["avr-gcc", *chip, *FLAGS, *(["-w"] if broken else WARNINGS), *flags]
    objects = [
        made([*words, "-c", name, "-o", "made.o"], headers | {name: texts[name]}, "made.o")
        for name in sorted(files)
    ]
    link = [*words, "-Wl,--gc-sections", *map(str, objects), "-lm", "-o", "firmware.elf"]
    return Elf(made(link, {}, "firmware.elf"))


def board_of(spec: str) -> BoardData:
    """Return the board of a spec's text, or of the example of that name."""
    return (spec_of(spec) if "\n" in spec else example(spec)).controller.board


class Board:
    """A processor with a program whose variables can be read and set."""

    def __init__(self, elf: Elf, board: BoardData) -> None:
        self.board = board
        self.avr = Avr(board.mcu, board.clock_hz)
        self.avr.load(elf)
        self._variables = Variables(elf)

    def put(self, name: str, value: float) -> None:
        """Set a variable of the program."""
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype).tobytes())

    def get(self, name: str) -> Any:
        """Read a variable of the program."""
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        return np.frombuffer(raw, variable.dtype)[0]
