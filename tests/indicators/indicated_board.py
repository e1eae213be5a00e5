"""A small oven whose loop is shown by LEDs, with its temperature and current in the test's hand."""

from rig.avr import whole
from rig.specs import spec_of

from heatwright.sim.circuits import Wiring
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.indicators import Indicators, Light

SPEC = """
heatwright: 1
controller: {name: shown, board: uno}
sensors:
  block:
    kind: thermistor
    pin: A0
    divider: {pull_up: 4.7 kΩ}
    curve: {resistance: 100 kΩ, at: 25 °C, beta: 4092 K}
    range: 0 °C .. 300 °C
    oversample: 16
  amps: {kind: current, pin: A1, scale: 0.2 V/A, offset: 0.5 V}
outputs:
  heater:
    kind: pwm
    pin: D9
    frequency: 1 kHz
    power: 76.6 W
    supply: 43 V
    current: {sensor: amps, limit: 3 A, trip: 9 A}
  cooler: {kind: digital, pin: D7}
loops:
  block:
    sensor: block
    heater: heater
    cooler: cooler
    period: 200 ms
    setpoint: {initial: 100 °C, minimum: 10 °C, maximum: 250 °C}
    algorithm: {kind: three_position, dead_band: 2 K}
    PROTECTION
safety: {watchdog: 1 s}
interfaces:
"""
PROTECTION = "protection: {maximum: 280 °C, minimum: 5 °C, rise_rate: 200 K/s, stale_after: 5 s"
LEDS = """\
  - kind: indicators
    leds: {D10: enabled, D11: heating, D12: cooling, D13: warm, D2: fault, D3: fault}
    active: ACTIVE
"""
MASTER = """\
  - {kind: modbus_rtu}
  - {kind: indicators, leds: {D10: enabled, D11: communicating}}
"""
IMPATIENT = f"# LOST\n{MASTER}"
"""The same with the rule `master_lost`."""
FULL_A = 76.6 / 43
STEP_S = 0.1
FASTEST_K = 10.0
"""Change of the temperature in a step; `rise_rate` allows twice that."""
SETTLED_S = 4.0
"""A step of the loop or some, the current's soft start, and two seconds of looking."""


def text_of(interfaces: str = LEDS, active: str = "high") -> str:
    """Write the spec."""
    lost = ", master_lost_after: 3 s" if "LOST" in interfaces else ""
    interfaces = interfaces.replace("ACTIVE", active).replace("# LOST\n", "")
    return SPEC.replace("PROTECTION", PROTECTION + lost + "}") + interfaces


class Shown:
    """The board, its sensors fed by hand; `strength` is the heater's current, in its own."""

    def __init__(
        self, interfaces: str = LEDS, active: str = "high", elf: Elf | None = None
    ) -> None:
        text = text_of(interfaces, active)
        self.device = AvrDevice(spec_of(text).controller, elf or whole(text))
        self.strength = 1.0
        self.temperature_c = 20.0
        self._felt_c = self.temperature_c
        self._now_s = 0.0
        (self.leds,) = (each for each in self.device.interfaces if isinstance(each, Indicators))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            share = self.device.on_fraction("heater")
            self.device.sense("amps", FULL_A * self.strength * share)
            self._felt_c += max(-FASTEST_K, min(FASTEST_K, self.temperature_c - self._felt_c))
            self.device.sense("block", self._felt_c)
            self._now_s += STEP_S
            self.device.advance(self._now_s)

    def open_sensor(self, *, opened: bool = True) -> None:
        sensor = self.device.sensors["block"]
        sensor.wiring = Wiring(opened=opened)  # type: ignore[attr-defined]

    def lights(self, seconds: float = SETTLED_S) -> dict[str, Light]:
        """Run on, then say what each LED shows."""
        self.run(seconds)
        self.device.feed()
        return self.leds.lights()

    def at(self, temperature_c: float, strength: float = 1.0) -> dict[str, Light]:
        self.temperature_c, self.strength = temperature_c, strength
        return self.lights()
