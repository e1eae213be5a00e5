"""On every board the slave answers after its silence, and lets go of the line after its answer."""

import pytest
from rig.avr import whole
from rig.specs import controller_of

from heatwright.sim.device import AvrDevice
from heatwright.spec import BOARDS

SPEC = """
heatwright: 1
controller: {{name: shape, board: {board}}}
sensors:
  air: {{kind: thermistor, pin: {sensor}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4,
    curve: {{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}}, range: -20 °C .. 300 °C}}
outputs:
  heater: {{kind: digital, pin: {heater}, power: 40 W}}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    algorithm: {{kind: on_off}}
    setpoint: {{initial: 20 °C, minimum: 0 °C, maximum: 250 °C}}
    protection: {{maximum: 280 °C, minimum: -10 °C, rise_rate: 20 K/s}}
interfaces:
  - {{kind: modbus_rtu, baud: {baud}, parity: {parity}, driver_enable: {driver}}}
"""
# Sensor, heater, driver.
PINS = {
    **dict.fromkeys(("uno", "nano", "leonardo"), ("A1", "D3", "D2")),
    "mega2560": ("A1", "D22", "D23"),
    "atmega328p": ("PC1", "PD3", "PD2"),
    "atmega2560": ("PF1", "PA0", "PA1"),
    **dict.fromkeys(("atmega1284p", "atmega32", "atmega16"), ("PA1", "PB0", "PD2")),
}
SOON_S = 0.001
"""An idle slave makes its answer in less: what a control step may wait for it."""
RELEASED_S = 10e-6
"""The interrupt behind the last stop bit, and another before it."""


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize(("baud", "parity"), [(1200, "odd"), (19_200, "none"), (115_200, "even")])
def test_it_answers(board: str, baud: int, parity: str) -> None:
    sensor, heater, driver = PINS[board]
    pins = {"sensor": sensor, "heater": heater, "driver": driver}
    spec = SPEC.format(board=board, baud=baud, parity=parity, **pins)
    device = AvrDevice(controller_of(spec), whole(spec))
    device.sense("air", 30.0)
    device.advance(3.0)
    device.write("air.setpoint", 45.5)
    device.advance(6.0)
    master = device.master
    assert device.read("settings.air_setpoint_c") == 45.5
    assert device.read("loop_air.setpoint_c") == 45.5
    assert master.values["air.temperature"] == pytest.approx(30, abs=1)
    assert master.slowest_s <= SOON_S
    assert master.refusals == []
    assert (master.bus.unheard, master.bus.collisions) == (0, 0)
    assert master.bus.slowest_release_s <= RELEASED_S
    assert device.read("modbus_counters.errors") == 0
