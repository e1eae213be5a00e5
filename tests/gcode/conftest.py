from pathlib import Path

import pytest
from gcode_world import gcode_world


@pytest.fixture(scope="session")
def world() -> Path:
    """The extruder's G-code as a program of this computer: see gcode_world."""
    return gcode_world().sanitized().program()
