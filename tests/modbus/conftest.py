from pathlib import Path

import pytest
from modbus_host import slave_world


@pytest.fixture(scope="session")
def slave_program() -> Path:
    """The slave as a program of this computer: see modbus_host."""
    return slave_world().sanitized().program()
