# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a project in the user's cache, and keep the binary for the next time."""

import dataclasses
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

from filelock import FileLock

from heatwright.generator.stack import StackUnknown, worst_stack
from heatwright.generator.toolchain import platformio
from heatwright.generator.toolchain.cache import cache_dir, digest, write_files
from heatwright.generator.toolchain.errors import BuildFailed, ToolMissing
from heatwright.generator.toolchain.offline import REMEDY
from heatwright.generator.toolchain.result import BuildResult, limits, sizes

# Raised when a change of this package gives other binaries or other figures from the same project.
FORMAT = "1"

IGNORED = {".pio", ".git", ".vscode", "__pycache__"}

ERROR = re.compile(
    r"error:|Error:|Error\b.*:|undefined reference|multiple definition|region .* overflowed"
)
UNREACHABLE = re.compile(r"InternetConnectionError|HTTPClientError|ConnectionError|Max retries")

Progress = Callable[[str], None]


def build(
    project_dir: Path,
    *,
    environment: str | None = None,
    progress: Progress | None = None,
) -> BuildResult:
    """Build the PlatformIO project in `project_dir` without writing there.

    The project is copied to the user's cache and built by `pio run`; the same project, built with
    the same tools, is built once. `environment` picks one of several in `platformio.ini`.
    `progress` is called with a short line as each step begins.

    Raises ToolMissing where PlatformIO or a compiler is not to be had, and BuildFailed with the
    compiler's errors where the project is at fault.
    """
    files = project_files(project_dir)
    say = progress or (lambda _: None)
    tools = platformio.find()
    folder = cache_dir() / "builds" / digest(files, FORMAT, tools.tools, environment or "")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{folder}.lock"):
        kept = recall(folder)
        if kept is not None:
            return kept
        shutil.rmtree(folder, ignore_errors=True)
        write_files(folder / "project", files)
        result = make(folder, tools, environment, say, project_dir)
        remember(folder, result)
    return result


def project_files(project_dir: Path) -> dict[str, bytes]:
    """Every file of the project, by path."""
    if not (project_dir / "platformio.ini").is_file():
        raise BuildFailed(f"{project_dir}: no PlatformIO project here: platformio.ini is missing")
    return {
        path.relative_to(project_dir).as_posix(): path.read_bytes()
        for path in sorted(project_dir.rglob("*"))
        if path.is_file() and not IGNORED & set(path.relative_to(project_dir).parts)
    }


def make(
    folder: Path,
    tools: platformio.PlatformIO,
    environment: str | None,
    say: Progress,
    project_dir: Path,
) -> BuildResult:
    """Run PlatformIO on the copy in `folder` and measure what it made."""
    lines: list[str] = []

    def hear(text: str) -> None:
        lines.append(text)
        if text.startswith(
            ("Compiling", "Linking", "Building .", "Platform Manager", "Tool Manager")
        ):
            say(text.replace(".pio/build/", ""))

    status = platformio.run(tools, folder / "project", environment, hear)
    log = "\n".join(lines).replace(str(folder / "project"), str(project_dir))
    if status != 0:
        if not tools.offline and UNREACHABLE.search(log):
            raise ToolMissing(REMEDY)
        raise BuildFailed(readable(log, project_dir), log)
    elf = only_elf(folder / "project", log)
    flash, ram = sizes(elf)
    flash_limit, ram_limit = limits(log)
    try:
        stack = worst_stack(elf).total
    except StackUnknown as reason:
        raise BuildFailed(
            f"{project_dir}: the worst stack cannot be told: {reason}", log
        ) from reason
    return BuildResult(elf, flash, ram, stack, flash_limit, ram_limit, log)


def only_elf(project: Path, log: str) -> Path:
    """Return the one binary that the build made."""
    found = sorted(project.glob(".pio/build/*/firmware.elf"))
    if len(found) != 1:
        names = ", ".join(path.parent.name for path in found) or "none"
        raise BuildFailed(f"one environment is built at a time, not {names}: set default_envs", log)
    return found[0]


def readable(log: str, project_dir: Path) -> str:
    """Return the errors of a failed build, each with the source line that the compiler showed."""
    lines = log.splitlines()
    kept: list[str] = []
    for number, text in enumerate(lines):
        if ERROR.search(text) and not text.startswith("***"):
            shown = [text, *lines[number + 1 : number + 3]] if "error:" in text else [text]
            kept += [line for line in shown if line.strip() and line not in kept]
    return "\n".join(
        [f"{project_dir}: PlatformIO could not build this project", *(kept or lines[-5:])]
    )


def remember(folder: Path, result: BuildResult) -> None:
    """Write the result beside the binary; only then does the folder count."""
    record = dataclasses.asdict(result) | {"elf": result.elf.relative_to(folder).as_posix()}
    fresh = folder / "result.json.new"
    fresh.write_text(json.dumps(record), encoding="utf-8")
    fresh.replace(folder / "result.json")


def recall(folder: Path) -> BuildResult | None:
    """Return what an earlier build left in `folder`."""
    try:
        record = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        elf = folder / record.pop("elf")
    except (OSError, ValueError, KeyError):
        return None
    return BuildResult(elf, **record | {"cached": True}) if elf.is_file() else None
