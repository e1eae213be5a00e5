"""Compile generated firmware by hand, with the flags that its own platformio.ini asks for."""

import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

from heatwright.spec import Board

# What PlatformIO's platform gives by itself; the project's build_unflags take the rest off.
PLATFORM = ["-Os", "-Wall", "-ffunction-sections", "-fdata-sections"]


def project_flags(ini: str) -> list[str]:
    """Return the build_flags of a platformio.ini."""
    found = re.search(r"^build_flags =\n((?: +.*\n)+)", ini, re.MULTILINE)
    assert found is not None
    flags = found[1].split()
    assert {"-Werror", "-Wpedantic", "-Wconversion", "-std=c11"} <= set(flags)
    return flags


def lay_out(files: Mapping[str, str], folder: Path) -> list[Path]:
    """Write a project; return its C files."""
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return sorted(folder.glob("src/*.c"))


def avr_gcc(*arguments: str | Path, cwd: Path) -> None:
    """Run the compiler; its words are the failure's."""
    done = subprocess.run(
        ["avr-gcc", *arguments], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def compile_and_link(files: Mapping[str, str], folder: Path, board: Board) -> Path:
    """Compile every C file by itself and link them all."""
    sources = lay_out(files, folder)
    flags = project_flags(files["platformio.ini"])
    chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL"]
    objects = folder / "objects"
    objects.mkdir()
    avr_gcc(*PLATFORM, *flags, *chip, "-c", *sources, cwd=objects)
    linked = [objects / f"{source.stem}.o" for source in sources]
    elf = folder / "firmware.elf"
    options = [flag for flag in flags if flag.startswith("-Wl,")]
    avr_gcc("-Os", *chip, *options, "-Wl,--gc-sections", *linked, "-lm", "-o", elf, cwd=folder)
    return elf
