import pytest
from machines import Kiln


@pytest.fixture
def kiln() -> Kiln:
    return Kiln()
