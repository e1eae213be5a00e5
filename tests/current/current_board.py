"""A heater whose current is measured, with that current in the test's hand."""

from rig.avr import whole
from rig.specs import spec_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.reference.current import Converter
from heatwright.sim.sensors.current import CurrentProbe
from heatwright.spec import Controller, CurrentSensor

SPEC = """
heatwright: 1
controller: {name: measured, board: BOARD}
sensors:
  air: {THERMOMETER}
  amps: {kind: current, SENSOR}
outputs:
  heater: {kind: digital, pin: D3, power: 60 W, supply: 24 V, current: {sensor: amps, trip: 4 A}}
loops:
  air:
    sensor: air
    heater: heater
    period: PERIOD
    setpoint: {initial: 25 °C, minimum: 20 °C, maximum: 70 °C}
    algorithm: {kind: on_off, hysteresis: 2 K}
    protection: {rising_while_off: off, heating: off, frozen: off}
"""
BOARDS = {"uno": "kind: ds18b20, pin: D2", "mega2560": "kind: ds18b20, pin: D22"}
CIRCUITS = {
    "shunt": "pin: A1, scale: 0.2 V/A",
    "once": "pin: A1, scale: 1 V/A, oversample: 1",
    "most": "pin: A3, scale: 0.5 V/A, oversample: 32",
    "hall": "pin: A1, scale: 0.185 V/A, offset: 2.5 V, oversample: 16",
    "odd": "pin: A2, scale: 0.4 V/A, offset: 0.333 V, oversample: 7, reference: 3.3 V",
    "internal": "pin: A1, scale: 0.1 V/A, reference: internal",
    "far": "pin: A13, scale: 0.2 V/A",
}
"""What a spec says of the sensor; `far` is on a channel beyond MUX5."""


def board_of(circuit: str) -> str:
    return "mega2560" if circuit == "far" else "uno"


def text_of(circuit: str, period: str = "1 s") -> str:
    board = board_of(circuit)
    text = SPEC.replace("THERMOMETER", BOARDS[board]).replace("BOARD", board)
    return text.replace("PERIOD", period).replace("SENSOR", CIRCUITS[circuit])


def controller_of(circuit: str) -> Controller:
    return spec_of(text_of(circuit)).controller


class Measured:
    def __init__(self, circuit: str, elf: Elf | None = None) -> None:
        self.controller = controller_of(circuit)
        self.device = AvrDevice(self.controller, elf or whole(text_of(circuit)))
        probe = self.device.sensors["amps"]
        assert isinstance(probe, CurrentProbe)
        self.probe = probe
        sensor = self.controller.sensors["amps"]
        assert isinstance(sensor, CurrentSensor)
        self.sensor = sensor
        self.law = Converter(sensor, self.controller.board)
        self.device.sense("air", 60.0)
        self._now_s = 0.02  # steps are at whole seconds and the first tick's microseconds

    def step(self, amperes: float) -> None:
        """Let a current flow for a period; the step that ends it is done."""
        self.device.sense("amps", amperes)
        self._now_s += 1.0
        self.device.advance(self._now_s)

    def run_on(self, seconds: float) -> None:
        """Go on for less than a period, then to its end with the next step."""
        self.device.advance(self._now_s + seconds)

    @property
    def raw(self) -> int:
        return int(self.device.read("current_heater.raw"))

    @property
    def amperes(self) -> float:
        return float(self.device.read("current_heater.amperes"))
