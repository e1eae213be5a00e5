# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong on the way from a project to a binary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from heatwright.generator.toolchain.result import BuildResult
    from heatwright.generator.toolchain.taken import Bytes


class ToolMissing(RuntimeError):
    """A program that the build needs is missing; the text is one line with the remedy."""


class BuildFailed(RuntimeError):
    """The project does not build; the text holds the errors, `log` everything printed."""

    def __init__(self, message: str, log: str = "") -> None:
        super().__init__(message)
        self.log = log


class CompilerFailed(BuildFailed):
    """PlatformIO, the compiler or the linker gave up; the text holds lines of theirs."""


class TooLarge(BuildFailed):
    """The program does not fit its chip; `built` is what was measured, for no chip can run it.

    `taken` says what of it each source file takes.
    """

    def __init__(self, message: str, built: BuildResult, taken: Mapping[str, Bytes]) -> None:
        super().__init__(message, built.log)
        self.built = built
        self.taken = taken
