# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a build, measured on the binary itself."""

import re
from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile

from heatwright.generator.toolchain.errors import BuildFailed

FLASH = (".text", ".data", ".rodata", ".bootloader")
RAM = (".data", ".bss", ".noinit")


@dataclass(frozen=True)
class BuildResult:
    """A binary, and the memory that it takes.

    Sizes are in bytes. `ram_bytes` is static: .data, .bss and .noinit. `stack_bytes` is the largest
    stack in addition, computed from the code: the deepest chain of calls from reset, with the
    deepest interrupt on top of it.
    """

    elf: Path
    flash_bytes: int
    ram_bytes: int
    stack_bytes: int
    flash_limit: int
    ram_limit: int
    log: str
    cached: bool = False

    @property
    def flash_over(self) -> int:
        """Return the bytes of flash above the chip's; negative: free bytes."""
        return self.flash_bytes - self.flash_limit

    @property
    def ram_over(self) -> int:
        """Return the bytes of variables and worst stack above the chip's; negative: free bytes."""
        return self.ram_bytes + self.stack_bytes - self.ram_limit


def sizes(elf: Path) -> tuple[int, int]:
    """Bytes of flash and of static RAM that the binary takes."""
    with elf.open("rb") as file:
        size = {section.name: section["sh_size"] for section in ELFFile(file).iter_sections()}
    return sum(size.get(name, 0) for name in FLASH), sum(size.get(name, 0) for name in RAM)


def limits(log: str) -> tuple[int, int]:
    """Read the board's bytes of flash and of RAM from PlatformIO's output."""
    found = dict(re.findall(r"^(RAM|Flash):.*from (\d+) bytes\)", log, re.MULTILINE))
    if found.keys() != {"Flash", "RAM"}:
        raise BuildFailed("PlatformIO does not know how much flash and RAM this board has", log)
    return int(found["Flash"]), int(found["RAM"])
