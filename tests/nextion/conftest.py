from pathlib import Path

import pytest
from hosted_kiln import GUARDED


@pytest.fixture(scope="session")
def hosted() -> Path:
    """A kiln's firmware as a program of this computer: see hosted_kiln."""
    return GUARDED.program()
