"""Minimum times in a whole firmware: a host's fan, and a heater whose protections do not wait."""

from rig.avr import whole
from rig.outputs import TICK_S, Recorded
from rig.specs import spec_of

from heatwright.sim.circuits import Wiring
from heatwright.sim.device import AvrDevice

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


class Held:
    """The board, its temperature in the test's hand."""

    def __init__(self) -> None:
        self.device = AvrDevice(spec_of(TEXT).controller, whole(TEXT))
        self.device.sense("air", 20.0)
        self._recorded = Recorded(self.device, "heater", "fan")

    def run(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)
        self.device.feed()

    def tell(self, line: str, seconds: float) -> None:
        """Send a line, and go on."""
        self.device.send(line)
        self.run(seconds)

    def changes(self, name: str) -> list[float]:
        """Return when it was switched, s; on first, then in turn."""
        return [cycle / 16e6 for cycle in self._recorded.cycles(name)]


def test_a_fan_of_the_host_keeps_its_minimum_times() -> None:
    board = Held()
    board.run(0.5)
    board.tell("M106 P0 S255", 2.5)
    board.tell("M107 P0", 4.0)
    board.tell("M106 P0 S255", 0.5)
    board.tell("M107 P0", 10.0)
    first, off, again, end = board.changes("fan")
    assert 2.0 <= first <= 2.0 + 2 * TICK_S  # off for two seconds from the reset on
    assert abs(off - first - 3.0) < 1e-3
    assert again - off >= 2.0
    assert abs(end - again - 3.0) < 1e-3


def heated() -> Held:
    """Begin with a heater that has just been switched on."""
    board = Held()
    board.run(12.0)
    board.tell("M104 T0 S50", 3.0)
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
    board.tell("M104 T0 S0", 3.0)
    _, off = board.changes("heater")
    assert off - told_s <= 1.0 + 0.1 + TICK_S
