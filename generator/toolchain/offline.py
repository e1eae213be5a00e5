# SPDX-License-Identifier: GPL-3.0-or-later
"""PlatformIO without its registry: a core directory made from programs of this computer.

PlatformIO looks for SCons, a compiler and a development platform in its core directory, and
downloads missing ones. Our directory has all three: SCons as installed by pip with PlatformIO, the
compiler on the PATH, and the small platform in `generator/platform/`.
"""

import json
import re
import subprocess
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from shutil import which

from heatwright.generator.toolchain.cache import folder_of
from heatwright.generator.toolchain.errors import ToolMissing
from heatwright.spec.boards import BOARDS, Board
from heatwright.spec.loading.user_cache import cache_dir

PLATFORM = Path(__file__).parents[1] / "platform"
STATE = "appstate.json"
"""The file that PlatformIO itself writes to its core directory, and repairs if damaged."""

REMEDY = (
    "the AVR compiler is missing: sudo apt-get install gcc-avr avr-libc binutils-avr"
    " (elsewhere: have avr-gcc, with avr-libc, on the PATH)"
)


def compiler() -> str | None:
    """Text that changes with the PATH's AVR compiler, library or linker; None if one is missing."""
    gcc, linker = which("avr-gcc"), which("avr-ld")
    if gcc is None or linker is None or which("avr-objcopy") is None:
        return None
    # Compiling with the library's version header shows that the library is there, too.
    asked = subprocess.run(  # noqa: S603
        [gcc, "-mmcu=atmega328p", "-E", "-dM", "-x", "c", "-include", "avr/version.h", "-"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    if asked.returncode != 0:
        return None
    macros = dict(
        re.findall(r'^#define (__VERSION__|__AVR_LIBC_VERSION_STRING__) "(.*)"', asked.stdout, re.M)
    )
    stamps = [f"{Path(tool).resolve().stat().st_mtime_ns}" for tool in (gcc, linker)]
    return " ".join([*macros.values(), *stamps])


def core_dir() -> Path:
    """Return PlatformIO's core directory in the user's cache, written on first use."""
    for module, package in (("platformio", "platformio"), ("SCons", "scons")):
        if find_spec(module) is None:
            raise ToolMissing(f"{package} is missing: pip install {package}")
    return folder_of(core_files(), cache_dir() / "platformio", changing={STATE})


def core_files() -> dict[str, bytes]:
    """Return all files of the core directory, by path."""
    files = {
        path.relative_to(PLATFORM).as_posix(): path.read_bytes()
        for path in sorted(PLATFORM.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }
    platform = json.loads(files["platforms/atmelavr/platform.json"])
    scons = scons_version()
    files |= package("platforms", "platform", "atmelavr", platform["version"])
    files |= package("packages", "tool", "tool-scons", scons)
    files |= package("packages", "tool", "toolchain-atmelavr", "1.0.0+system")
    files |= boards()
    # Without it PlatformIO greets a new user; with an older version it upgrades its packages.
    files[STATE] = json.dumps({"last_version": version("platformio")}).encode()
    return files


def boards() -> dict[str, bytes]:
    """Return the files with PlatformIO's data of each board, by path."""
    known = {board.platformio: board for board in BOARDS.values()}
    # Nanos sold since 2018 differ only in the upload.
    known["nanoatmega328new"] = BOARDS["nano"]
    return {
        f"platforms/atmelavr/boards/{name}.json": json.dumps(manifest(board)).encode()
        for name, board in known.items()
    }


def manifest(board: Board) -> dict[str, object]:
    """Return the data of a board in PlatformIO's form."""
    return {
        "name": board.name,
        "vendor": "heatwright",
        "url": "",
        "build": {"mcu": board.mcu, "f_cpu": f"{board.clock_hz}L"},
        "upload": {
            "maximum_size": board.flash_bytes - board.bootloader_bytes,
            "maximum_ram_size": board.ram_bytes,
        },
    }


def scons_version() -> str:
    """Version of the SCons package that PlatformIO needs, such as 4.41101.0 for SCons 4.11.1."""
    from platformio.dependencies import get_core_dependencies  # noqa: PLC0415

    return str(get_core_dependencies()["tool-scons"]).lstrip("~^=")


def package(folder: str, kind: str, name: str, number: str) -> dict[str, bytes]:
    """Return the one or two files by which PlatformIO recognises a folder as a package, by path."""
    spec = {"owner": "platformio", "id": None, "name": name, "requirements": None, "uri": None}
    record = {"type": kind, "name": name, "version": number, "spec": spec}
    files = {f"{folder}/{name}/.piopm": json.dumps(record).encode()}
    if kind == "tool":
        manifest = {"name": name, "version": number, "system": "*"}
        files[f"{folder}/{name}/package.json"] = json.dumps(manifest).encode()
    return files
