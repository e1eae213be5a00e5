from pathlib import Path

import pytest
from powered import PowerOn

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import Controller


@pytest.fixture(scope="session")
def chamber_program(chamber_elf: Path) -> Elf:
    return Elf(chamber_elf)


@pytest.fixture
def power_on(chamber: Controller, chamber_program: Elf) -> PowerOn:
    """The chamber's controller just powered on, its sensor at a temperature, its EEPROM given."""

    def powered(*, temperature_c: float = 19.0, eeprom: bytes = b"") -> AvrDevice:
        device = AvrDevice(chamber, chamber_program)
        device.avr.eeprom.contents = eeprom
        device.sense("air", temperature_c)
        return device

    return powered
