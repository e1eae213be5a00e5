"""Two baths with a DS18B20 each, and 85 °C: what also a chip says that has not measured yet."""

from typing import Any

import pytest
from rig.firmware import device_of

from heatwright.sim.device import AvrDevice

SPEC = """
heatwright: 1
controller: {{name: baths, board: uno}}
sensors:
  left: {{kind: ds18b20, pin: A1, resolution: {0} bit}}
  right: {{kind: ds18b20, pin: A2, resolution: {1} bit}}
outputs: {{left: {{kind: digital, pin: D3}}, right: {{kind: digital, pin: D4}}}}
loops:
  left: {{sensor: left, heater: left, period: {2} ms, algorithm: {{kind: on_off}}, {4}}}
  right: {{sensor: right, heater: right, period: {3} ms, algorithm: {{kind: on_off}}, {4}}}
"""
HOT = "setpoint: {initial: 90 °C, minimum: 10 °C, maximum: 95 °C}, protection: {stale_after: 6 s}"


def held(device: AvrDevice, felt_c: float, **faults: Any) -> list[Any]:
    """Cut the power, go on with such chips, and return the steps of each loop."""
    device.power_cycle()
    done = {name: len(device.steps(name)) for name in device.sensors}
    for chip in device.sensors.values():
        chip.undefined_bits = 0
        chip.sense(felt_c)
        vars(chip.faults).update(faults)
    device.advance(device.time_s + 14.05)
    return [device.steps(name)[first:] for name, first in done.items()]


@pytest.mark.parametrize("bits", range(9, 13))
def test_a_power_cut_at_85_degrees(bits: int) -> None:
    text = SPEC.format(bits, 21 - bits, 350 << bits - 9, 350 << 12 - bits, HOT)
    device = device_of(text)
    for steps in held(device, 85.0) + held(device, 85.0):
        assert ({*steps["reading_status"]}, {*steps["temperature_c"]}) == ({0}, {85.0})
    assert (device.read("fault.code"), device.outputs["left"].on) == (0, True)
    for faults in ({"idle": True}, {"weak": True}, {"slow": 5.5}):
        for steps in held(device, 20.0, **faults):  # none of these chips is believed
            measured = steps["reading_status"] == 0
            assert {*steps["reading_status"][~measured]} == {5}
            assert {*steps["reading_raw"][measured]} == ({320} if "slow" in faults else set())


def test_an_exchange_that_has_lost_its_place_ends() -> None:
    """A bit that flips in RAM must not have it write all over the memory until it finds its end."""
    text = SPEC.format(12, 12, 1000, 1000, HOT)
    device = device_of(text)
    place = device.variables["one_wire_left.index"]
    device.advance(0.1)
    while not (device.read("one_wire_left.busy") and device.read("one_wire_left.index") > 2):
        device.advance(device.time_s + 0.0003)
    device.avr.write_ram(place.address, bytes([int(device.read("one_wire_left.size")) + 1]))
    device.advance(device.time_s + 0.002)
    assert not device.read("one_wire_left.busy")
