from pathlib import Path

import pytest
from gcode_world import gcode_world


@pytest.fixture(scope="session")
def world() -> Path:
    return gcode_world().sanitized().program()
