# SPDX-License-Identifier: GPL-3.0-or-later
"""Run PlatformIO as a child process: quiet, without telemetry, ended together with this one."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from heatwright.generator.toolchain import offline
from heatwright.generator.toolchain.errors import ToolMissing

# The environment variable that forces a way to build: `offline` or `online`.
CHOICE = "HEATWRIGHT_PLATFORMIO"

QUIET = {
    "PLATFORMIO_DISABLE_PROGRESSBAR": "true",
    "PLATFORMIO_DISABLE_UPGRADE_CHECK": "true",
    "PLATFORMIO_NO_ANSI": "true",
    "PLATFORMIO_SETTING_CHECK_PRUNE_SYSTEM_THRESHOLD": "0",
    "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "false",
}


@dataclass(frozen=True)
class PlatformIO:
    """A PlatformIO to build with: its core directory, and the versions of its tools."""

    core: Path
    tools: str
    offline: bool


def find() -> PlatformIO:
    """Choose the way to build: without the registry if the system has an AVR compiler."""
    choice = os.environ.get(CHOICE, "auto")
    if choice not in ("auto", "offline", "online"):
        raise ToolMissing(f"{CHOICE}={choice}: unknown; set it to offline, online or auto")
    if find_spec("platformio") is None:
        raise ToolMissing("PlatformIO is missing: pip install platformio")
    compiler = offline.compiler() if choice != "online" else None
    if compiler is not None:
        core = offline.core_dir()
        tools = f"{core.name} {version('platformio')} {version('scons')} {compiler}"
        return PlatformIO(core, tools, offline=True)
    if choice == "offline":
        raise ToolMissing(offline.REMEDY)
    return online()


def online() -> PlatformIO:
    """Return the user's own PlatformIO, which downloads missing packages."""
    core = Path(os.environ.get("PLATFORMIO_CORE_DIR", Path.home() / ".platformio"))
    patterns = "platforms/atmelavr*/.piopm", "packages/toolchain-atmelavr*/.piopm"
    manifests = sorted(file for pattern in patterns for file in core.glob(pattern))
    installed = " ".join(manifest.read_text(encoding="utf-8") for manifest in manifests)
    return PlatformIO(core, f"{version('platformio')} {installed}", offline=False)


def run(
    platformio: PlatformIO,
    project: Path,
    environment: str | None,
    line: Callable[[str], None],
    flags: str = "",
) -> int:
    """Build `project`, pass on each line of output, and return the exit status.

    `flags` are for the compiler and the linker, in addition to those of the project.
    """
    command = [sys.executable, "-m", "platformio", "run", "--project-dir", str(project)]
    if environment is not None:
        command += ["--environment", environment]
    with subprocess.Popen(  # noqa: S603
        command,
        env=surroundings(platformio) | ({"PLATFORMIO_BUILD_FLAGS": flags} if flags else {}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    ) as child:
        try:
            assert child.stdout is not None  # noqa: S101
            for text in child.stdout:
                line(text.rstrip())
            return child.wait()
        except BaseException:
            end(child)
            raise


def surroundings(platformio: PlatformIO) -> dict[str, str]:
    """Return the child's environment: the user's without variables that change the binary."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("PLATFORMIO_")}
    return kept | QUIET | {"PLATFORMIO_CORE_DIR": str(platformio.core)}


def end(child: subprocess.Popen[str]) -> None:
    """End the child and all processes that it started: they are in one process group."""
    if sys.platform == "win32":
        child.kill()
        return
    for sign in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(child.pid, sign)
            child.wait(timeout=2)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue
