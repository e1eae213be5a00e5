import pytest
from menu_desk import CONTROLLER, MenuDesk
from rig.avr import whole

from heatwright.sim.device import AvrDevice


@pytest.fixture(scope="session")
def device() -> AvrDevice:
    return AvrDevice(CONTROLLER, whole("kiln_uno"))


@pytest.fixture
def desk(device: AvrDevice) -> MenuDesk:
    """The kiln with keys, nothing on, its first screen shown."""
    return MenuDesk(device)
