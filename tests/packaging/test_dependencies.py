"""What is pinned together fits together."""

import re
from importlib.metadata import version

from platformio.dependencies import get_core_dependencies


def test_scons_is_the_one_that_platformio_asks_for() -> None:
    # PlatformIO writes SCons 4.11.1 as 4.41101.0.
    asked = get_core_dependencies()["tool-scons"]
    major, minor, patch = map(int, version("scons").split("."))
    assert re.fullmatch(rf"~{major}\.{major}{minor:02}{patch:02}\.\d+", asked)
