# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong on the way from a project to a binary."""


class ToolMissing(RuntimeError):
    """A program that the build needs is missing; the text is one line with the remedy."""


class BuildFailed(RuntimeError):
    """The project does not build; the text holds the errors, `log` everything printed."""

    def __init__(self, message: str, log: str = "") -> None:
        super().__init__(message)
        self.log = log
