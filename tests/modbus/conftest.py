from collections.abc import Mapping
from pathlib import Path

import pytest
from modbus_host import SLAVE, slave_world
from rig.specs import files_of


@pytest.fixture(scope="session")
def slave_files() -> Mapping[str, str]:
    return files_of(SLAVE)


@pytest.fixture(scope="session")
def slave_program() -> Path:
    """The slave as a program of this computer: see modbus_host."""
    return slave_world().sanitized().program()
