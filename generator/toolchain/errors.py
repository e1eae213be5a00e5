# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors of building a binary from a project."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from heatwright.generator.toolchain.result import BuildResult
    from heatwright.generator.toolchain.taken import Bytes


class ToolMissing(RuntimeError):
    """A program that the build needs is missing; the text is one line, with the remedy."""


class BuildFailed(RuntimeError):
    """The project cannot be built; the text has the errors, `log` the whole output."""

    def __init__(self, message: str, log: str = "") -> None:
        super().__init__(message)
        self.log = log


class CompilerFailed(BuildFailed):
    """PlatformIO, the compiler or the linker failed; the text has lines of their output."""


class TooLarge(BuildFailed):
    """The program does not fit its chip; `built` has its measures, though no chip can run it.

    `taken` is the memory that each source file takes.
    """

    def __init__(self, message: str, built: BuildResult, taken: Mapping[str, Bytes]) -> None:
        super().__init__(message, built.log)
        self.built = built
        self.taken = taken
