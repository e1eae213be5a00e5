import pytest
from programmed_kiln import Kiln
from switched_loops import Nozzle


@pytest.fixture
def kiln() -> Kiln:
    return Kiln()


@pytest.fixture
def nozzle() -> Nozzle:
    return Nozzle()
