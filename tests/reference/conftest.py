import pytest
from programmed_kiln import Kiln


@pytest.fixture
def kiln() -> Kiln:
    return Kiln()
