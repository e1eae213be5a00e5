# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a project in the user's cache, and keep the binary for later calls.

A binary that was built elsewhere is measured in the same way.
"""

import re
import shutil
import struct
from collections.abc import Callable
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import NoteSection
from filelock import FileLock

from heatwright.generator.stack import StackUnknown, worst_stack
from heatwright.generator.toolchain import platformio
from heatwright.generator.toolchain.cache import digest, forget_old, recall, remember, write_files
from heatwright.generator.toolchain.errors import BuildFailed, CompilerFailed, TooLarge, ToolMissing
from heatwright.generator.toolchain.offline import REMEDY
from heatwright.generator.toolchain.result import BuildResult, limits, sizes
from heatwright.generator.toolchain.taken import taken
from heatwright.spec import Board
from heatwright.spec.loading.user_cache import cache_dir

# To be changed whenever this package returns other measures for the same binary.
FORMAT = "1"

IGNORED = {".pio", ".git", ".vscode", "__pycache__"}

STEPS = ("Compiling", "Linking", "Platform Manager", "Tool Manager", "Downloading", "Unpacking")
ERROR = re.compile(
    r"error:|Error:|undefined reference|multiple definition|overflowed|not within region"
)
TOO_LARGE = re.compile(
    r"region .* overflowed|will not fit in region|not within region|greater than maximum allowed"
)
ANY_SIZE = "-Wl,--defsym=__TEXT_REGION_LENGTH__=0x400000,--defsym=__DATA_REGION_LENGTH__=0xff00"
"""Linker options for memories as large as possible: so a program that is too large for its chip can
be linked and measured."""
UNREACHABLE = re.compile(r"InternetConnectionError|HTTPClientError|ConnectionError")

BINARY = ".pio/build/*/firmware.elf"

Progress = Callable[[str], None]


def build(
    project_dir: Path, *, environment: str | None = None, progress: Progress | None = None
) -> BuildResult:
    """Build the PlatformIO project in `project_dir` without writing there.

    The project is copied to the user's cache and built by `pio run`; the same project is built once
    by the same tools. `environment` picks one of several in `platformio.ini`. `progress` is called
    with a short line as each step begins. Raises ToolMissing: PlatformIO or a compiler is missing;
    BuildFailed: the project cannot be built, with the compiler's errors; TooLarge, a BuildFailed:
    the program does not fit, with its measures.
    """
    files = project_files(project_dir)
    tools = platformio.find()
    folder = cache_dir() / "builds" / digest(files, FORMAT, tools.tools, environment or "")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{folder}.lock"):
        result = recall(folder)
        if result is None:
            shutil.rmtree(folder, ignore_errors=True)
            write_files(folder / "project", files)
            log = run(folder / "project", project_dir, tools, environment, progress)
            result = measured(folder / "project", project_dir, log)
            remember(folder, result)
            forget_old(folder.parent)
        refuse_too_large(result, project_dir)
    return result


def project_files(project_dir: Path) -> dict[str, bytes]:
    """Return the content of every file of the project that is not in IGNORED, by path."""
    if not (project_dir / "platformio.ini").is_file():
        raise BuildFailed(f"{project_dir}: no PlatformIO project here: platformio.ini is missing")
    return {
        path.relative_to(project_dir).as_posix(): path.read_bytes()
        for path in sorted(project_dir.rglob("*"))
        if path.is_file() and not IGNORED & set(path.relative_to(project_dir).parts)
    }


def run(
    copy: Path,
    project_dir: Path,
    tools: platformio.PlatformIO,
    environment: str | None,
    progress: Progress | None,
) -> str:
    """Run PlatformIO on the copy of the project; return its output."""
    lines: list[str] = []

    def hear(text: str) -> None:
        lines.append(text)
        if progress is not None and text.startswith(STEPS):
            progress(text.replace(".pio/build/", ""))

    status = platformio.run(tools, copy, environment, hear)
    if status != 0 and TOO_LARGE.search("\n".join(lines)):
        if not any(copy.glob(BINARY)):
            platformio.run(tools, copy, environment, hear, flags=ANY_SIZE)
        status = 0 if any(copy.glob(BINARY)) else status
    log = "\n".join(lines).replace(str(copy), str(project_dir))
    if status != 0 and not tools.offline and UNREACHABLE.search(log):
        raise ToolMissing(f"PlatformIO reaches no registry, and {REMEDY}")
    if status != 0:
        raise CompilerFailed(readable(log, project_dir), log)
    return log


def measured(copy: Path, project_dir: Path, log: str) -> BuildResult:
    """Measure the binary that a build made."""
    elf = only_elf(copy, log)
    flash, ram = sizes(elf)
    flash_limit, ram_limit = limits(log)
    try:
        stack = worst_stack(elf).total
    except StackUnknown as reason:
        raise BuildFailed(f"{project_dir}: the worst stack is unknown: {reason}", log) from reason
    return BuildResult(elf, flash, ram, stack, flash_limit, ram_limit, log)


def refuse_too_large(built: BuildResult, what: Path) -> None:
    """Raise TooLarge if the binary with its worst stack does not fit its chip."""
    ways = []
    if built.flash_over > 0:
        ways.append(f"{built.flash_bytes} bytes of flash, of {built.flash_limit}")
    if built.ram_over > 0:
        ways.append(
            f"{built.ram_bytes} bytes of variables and {built.stack_bytes} bytes of stack at worst"
            f" do not fit into {built.ram_limit} bytes of RAM"
        )
    if ways:
        raise TooLarge(f"{what}: {'; '.join(ways)}", built, taken(built.elf))


def only_elf(copy: Path, log: str) -> Path:
    """Return the one binary that a build made."""
    found = sorted(copy.glob(BINARY))
    if len(found) != 1:
        names = ", ".join(path.parent.name for path in found) or "none"
        raise BuildFailed(f"one environment is built at a time, not {names}: set default_envs", log)
    return found[0]


def readable(log: str, project_dir: Path) -> str:
    """Return the errors of a failed build, each with the source line that the compiler showed."""
    lines = log.splitlines()
    kept: set[int] = set()
    for number, text in enumerate(lines):
        if ERROR.search(text):
            kept.update(range(number, number + 3) if " error: " in text else [number])
    shown = [lines[number] for number in sorted(kept) if number < len(lines)] or lines[-5:]
    return "\n".join([f"{project_dir}: PlatformIO could not build it", *shown])


DEVICE = ".note.gnu.avr.deviceinfo"
"""Section in which avr-libc's start-up code names its chip (binutils: the AVR ELF ABI)."""
MEMORIES = struct.calcsize("<6I")
"""Size of the section's first part: start and size of flash, RAM and EEPROM. Strings follow it."""


def given(elf: Path, board: Board) -> BuildResult:
    """Measure the AVR program in `elf` for the board.

    Raises BuildFailed: its worst stack is unknown; TooLarge: it does not fit.
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
    """Return the name of the chip that a program was linked for; "" if the program has none."""
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
