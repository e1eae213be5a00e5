# SPDX-License-Identifier: GPL-3.0-or-later
"""Processor time of commands, least of several, those that are compared in turns; and the yard."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[2]
HEATWRIGHT = Path(sys.executable).with_name("heatwright")
EXAMPLES = ROOT / "spec" / "examples"
JUDGES = ROOT / "build" / "judges"

YARD = "x = 0\nfor each in range(10_000_000):\n    x = x + 1\n"
"""Its processor time, with that of starting Python, is the yard: a unit that any machine has."""

Command = Sequence[str | Path]
Tell = Callable[[str], None]
"""Called with what is measured next."""


class Failed(RuntimeError):
    """A command that was to be measured has failed."""


class Ran(NamedTuple):
    """What became of a command: processor time with that of all its children, s, and its output.

    wall_s -- what the clock on the wall says, s.
    """

    processor_s: float
    output: str
    wall_s: float


def ran(command: Command, cwd: Path | None = None) -> Ran:
    """Run a command; it must end well."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun_s = time.monotonic()
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)  # noqa: S603
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        words = " ".join(map(str, command))
        raise Failed(f"{words} ended with {done.returncode}:\n{done.stderr[-2000:]}")
    took_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Ran(took_s, done.stdout, time.monotonic() - begun_s)


def least_s(
    commands: Mapping[str, Command], times: int, cwd: Path | None = None
) -> dict[str, float]:
    """Return the least processor time of each command; they take turns, so that all are alike."""
    least = dict.fromkeys(commands, float("inf"))
    for _ in range(times):
        for name, command in commands.items():
            least[name] = min(least[name], ran(command, cwd).processor_s)
    return least


def built(spec: Path) -> None:
    """Put the binary into the cache: compiling is avr-gcc's time, and done once."""
    with TemporaryDirectory() as folder:
        ran((HEATWRIGHT, "build", spec), cwd=Path(folder))


def yard_command() -> Command:
    """Return what takes a yard."""
    return (sys.executable, "-S", "-E", "-c", YARD)


def yard_s(times: int = 3) -> float:
    """Return the least of several yards, s."""
    return least_s({"yard": yard_command()}, times)["yard"]


def machine() -> dict[str, Any]:
    """Name the machine, by what decides about speed and by nothing that would tell whose it is."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": models[0] if models else "unknown",
        "cores": os.cpu_count(),
        "python": ".".join(map(str, sys.version_info[:3])),
    }
