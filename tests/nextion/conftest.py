from pathlib import Path

import pytest
from hosted_kiln import GUARDED
from kiln_desk import KilnDesk


@pytest.fixture
def desk() -> KilnDesk:
    """The kiln, its display started, nothing on."""
    made = KilnDesk()
    made.run(2.0)
    return made


@pytest.fixture(scope="session")
def hosted() -> Path:
    """A kiln's firmware as a program of this computer: see hosted_kiln."""
    return GUARDED.program()
