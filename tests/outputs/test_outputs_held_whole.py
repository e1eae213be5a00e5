"""Minimum times in a whole firmware: a host's fan, and a heater whose protections do not wait."""

import numpy as np
from rig.avr import whole
from rig.specs import spec_of

from heatwright.sim.circuits import Wiring
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.native.pins import pin_number

TEXT = """
heatwright: 1
controller: {name: held, board: uno}
sensors:
  air:
    kind: thermistor
    pin: A1
    divider: {pull_up: 4.7 kΩ}
    curve: {resistance: 10 kΩ, at: 25 °C, beta: 3950 K}
    range: 0 °C .. 150 °C
outputs:
  heater: {kind: digital, pin: D3, power: 40 W, minimum_on: 20 s, minimum_off: 10 s}
  fan: {kind: digital, pin: D7, minimum_on: 3 s, minimum_off: 2 s}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 0 °C, minimum: 10 °C, maximum: 70 °C}
    algorithm: {kind: on_off}
    protection: {minimum: 5 °C, rise_rate: 50 K/s}
interfaces: [{kind: gcode, loops: {T0: air}, fans: {P0: fan}}]
"""
PINS = {"heater": "PD3", "fan": "PD7"}
TICK_S = 0.01


class Held:
    """The board, its temperature in the test's hand."""

    def __init__(self, elf: Elf | None = None) -> None:
        self.device = AvrDevice(spec_of(TEXT).controller, elf or whole(TEXT))
        self.device.sense("air", 20.0)
        self._now_s = 0.0
        self._seen = {name: [(0.0, False)] for name in PINS}
        self.device.record(self)

    def run(self, seconds: float) -> None:
        self._now_s += seconds
        self.device.advance(self._now_s)
        self.device.feed()

    def feed(self, pins: np.ndarray, sent: np.ndarray) -> None:
        """Take pin changes: a recorder of the device."""
        del sent
        for name, pin in PINS.items():
            for event in pins[pins["pin"] == pin_number(pin)]:
                on = bool(event["state"] & 1)
                if on != self._seen[name][-1][1]:
                    self._seen[name].append((float(event["cycle"]) / 16e6, on))

    def changes(self, name: str) -> list[float]:
        """Return when it was switched, s; on first, then in turn."""
        return [at_s for at_s, _ in self._seen[name][1:]]


def test_a_fan_of_the_host_keeps_its_minimum_times() -> None:
    board = Held()
    board.run(0.5)
    board.device.send("M106 P0 S255")
    board.run(2.5)
    board.device.send("M107 P0")
    board.run(4.0)
    board.device.send("M106 P0 S255")
    board.run(0.5)
    board.device.send("M107 P0")
    board.run(10.0)
    first, off, again, end = board.changes("fan")
    assert 2.0 <= first <= 2.0 + 2 * TICK_S  # off for two seconds from the reset on
    assert abs(off - first - 3.0) < 1e-3
    assert again - off >= 2.0
    assert abs(end - again - 3.0) < 1e-3


def heated(elf: Elf | None = None) -> Held:
    """Begin with a heater that has just been switched on."""
    board = Held(elf)
    board.run(12.0)
    board.device.send("M104 T0 S50")
    board.run(3.0)
    assert len(board.changes("heater")) == 1
    return board


def test_at_the_setpoint_a_heater_stays_on_for_its_minimum() -> None:
    board = heated()
    board.device.sense("air", 55.0)
    board.run(30.0)
    on, off = board.changes("heater")
    assert abs(off - on - 20.0) < 1e-3
    board.device.sense("air", 40.0)
    board.run(20.0)
    again = board.changes("heater")[2]
    assert again - off >= 10.0


def test_without_a_reading_it_waits_for_nothing() -> None:
    board = heated()
    told_s = board.device.time_s
    board.device.sensors["air"].wiring = Wiring(opened=True)  # type: ignore[attr-defined]
    board.run(3.0)
    _, off = board.changes("heater")
    assert off - told_s <= 2.0 + TICK_S
    assert not board.device.read("fault.code")


def test_switched_off_by_the_host_it_waits_for_nothing() -> None:
    board = heated()
    told_s = board.device.time_s
    board.device.send("M104 T0 S0")
    board.run(3.0)
    _, off = board.changes("heater")
    assert off - told_s <= 1.0 + 0.1 + TICK_S
