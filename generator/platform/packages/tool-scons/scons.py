# SPDX-License-Identifier: GPL-3.0-or-later
"""Start the SCons that is installed beside PlatformIO, where PlatformIO looks for its own copy."""

import SCons.Script

SCons.Script.main()
