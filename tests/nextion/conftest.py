from pathlib import Path

import pytest
from hosted_kiln import GUARDED


@pytest.fixture(scope="session")
def hosted() -> Path:
    return GUARDED.program()
