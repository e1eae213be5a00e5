# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a binary from a generated project with PlatformIO, and measures it."""

from heatwright.generator.toolchain.build import build
from heatwright.generator.toolchain.errors import BuildFailed, CompilerFailed, TooLarge, ToolMissing
from heatwright.generator.toolchain.result import BuildResult
