import pytest
from register_reader import WIRES, RegisterReader

from heatwright.sim.sensors.max31856 import Max31856


@pytest.fixture
def reader() -> RegisterReader:
    return RegisterReader()


@pytest.fixture
def chip(reader: RegisterReader) -> Max31856:
    return Max31856(reader.avr, WIRES)
