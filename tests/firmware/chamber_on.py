"""The chamber's controller just powered on."""

from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.native.pins import pin_number

CHAMBER = example("chamber").controller
ROOM_C = 19.0
SETPOINT = "settings.air_setpoint_c"
HEATER, FAN = pin_number("PD3"), pin_number("PB3")


def program() -> Elf:
    """Return the firmware; an arena puts a broken one in its place."""
    return whole("chamber")


def power_on(eeprom: bytes = b"", felt_c: float = ROOM_C, elf: Elf | None = None) -> AvrDevice:
    """Return the chamber's controller at time 0, its sensor at a temperature."""
    device = AvrDevice(CHAMBER, elf or program())
    device.avr.eeprom.contents = eeprom
    device.sense("air", felt_c)
    return device


def latched() -> AvrDevice:
    """Power on with an EEPROM that holds an unacknowledged fault."""
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].unplug()  # type: ignore[attr-defined]
    device.advance(12.0)
    assert device.read("fault.code") == 1
    return power_on(device.avr.eeprom.contents)


def press(device: AvrDevice, key: str, for_s: float = 0.1) -> None:
    """Press a key and let it go."""
    device.press(key)
    device.advance(device.time_s + for_s)
    device.press(None)
    device.advance(device.time_s + 0.1)


def put(device: AvrDevice, name: str, value: int) -> None:
    """Set a variable of the firmware."""
    variable = device.variables[name]
    device.avr.write_ram(variable.address, value.to_bytes(variable.size, "little"))
