from pathlib import Path

import pytest
from hosted_kiln import GUARDED
from kiln_desk import Built, KilnDesk
from rig.avr import whole
from rig.specs import example


@pytest.fixture(scope="session")
def kiln() -> Built:
    """The kiln's firmware."""
    return Built(example("kiln").controller, whole("kiln"))


@pytest.fixture
def desk(kiln: Built) -> KilnDesk:
    """The kiln, its display started, nothing on."""
    made = KilnDesk(kiln)
    made.run(2.0)
    return made


@pytest.fixture(scope="session")
def hosted() -> Path:
    """A kiln's firmware as a program of this computer: see hosted_kiln."""
    return GUARDED.program()
