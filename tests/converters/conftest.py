import pytest
from rig.chips import THREE_WIRES, Reader

from heatwright.sim.sensors.max6675 import Max6675
from heatwright.sim.sensors.max31855 import Max31855


@pytest.fixture
def reader() -> Reader:
    return Reader()


@pytest.fixture
def max6675(reader: Reader) -> Max6675:
    return Max6675(reader.avr, THREE_WIRES)


@pytest.fixture
def max31855(reader: Reader) -> Max31855:
    return Max31855(reader.avr, THREE_WIRES)
