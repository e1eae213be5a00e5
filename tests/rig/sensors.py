"""Sensors before a firmware: a crucible's converter on SPI wires; analog ones of every circuit."""

from functools import cache
from typing import Any

import yaml
from numpy.typing import NDArray
from pydantic import TypeAdapter
from rig.firmware import device_of, spec_of, whole

from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.sensors.spi_chip import SpiChip
from heatwright.spec import Analog, Rtd, Sensor, Thermistor

PINS = {
    "uno": ("D10", "D8", "D12", "D11", "D9"),
    "leonardo": ("D5", "A5", "D8", "D10", "D9"),
    "mega2560": ("D49", "A8", "D17", "D48", "D5"),  # ports L, K and H: beyond the reach of SBI
    "atmega1284p": ("PC0", "PA7", "PB1", "PB2", "PD5"),
}
"""By board: CS, SCK, the chip's output, its input, heater."""
PERIOD_S = {"max6675": 0.3, "max31855": 0.3, "max31856": 0.35}
KINDS = tuple(PERIOD_S)
MINIMUM = {"max6675": "6 °C", "max31855": "-30 °C", "max31856": "-30 °C"}
CRUCIBLE = """
heatwright: 1
controller: {{name: crucible, board: {board}{clock}}}
sensors:
  tip: {{kind: {kind}, {wires}{extra}}}
outputs:
  heater: {{kind: pwm, pin: {heater}, frequency: 122 Hz, power: 40 W}}
loops:
  crucible:
    sensor: tip
    heater: heater
    period: {period_ms:g} ms
    setpoint: {{initial: 200 °C, minimum: 20 °C, maximum: 250 °C}}
    algorithm: {{kind: pid, kp: 25, ki: 0.4, kd: 60, derivative_filter: 1 s}}
    protection:
      maximum: 285 °C
      minimum: {minimum}
      rise_rate: 20 K/s
      heating: {{rise: 2 K, within: 25 s}}
      runaway: {{above: 15 K, below: 15 K, for: 25 s}}
      stale_after: 2 s
safety: {{watchdog: 1 s, self_checks: false}}
{more}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {{crucible: 20 J/K}}
    links: [{{between: [crucible, ambient], resistance: 11 K/W}}]
    heat: {{heater: crucible}}
    sense: {{tip: {{node: crucible, lag: 3 s}}}}
  scenario:
    - {{for: 600 s}}
"""
HOTTER = {
    "initial: 200 °C, minimum: 20 °C": "initial: 600 °C, minimum: 300 °C",
    "maximum: 250 °C": "maximum: 650 °C", "minimum: -30 °C": "minimum: 260 °C",
    "maximum: 285 °C": "maximum: 700 °C", "ambient: 20 °C": "ambient: 280 °C",
}  # fmt: skip
"""For type B, which measures nothing below 250 °C."""


def crucible(kind: str, board: str = "uno", *, period_s: float = 0, **said: str) -> str:
    """Write the spec of a crucible under PID with a converter. `clock` and `extra` are what more
    the file says of the controller and of the converter, `more` are further sections."""
    select, sck, out, into, heater = PINS[board]
    wires = f"chip_select: {select}, clock: {sck}, data_out: {out}"
    wires += f", data_in: {into}" if kind == "max31856" else ""
    given = {"kind": kind, "board": board, "wires": wires, "heater": heater}
    given |= {"clock": "", "extra": "", "more": "", "minimum": MINIMUM[kind]} | said
    text = CRUCIBLE.format(period_ms=1000 * (period_s or PERIOD_S[kind]), **given)
    for usual, hot in HOTTER.items() if "thermocouple: B" in given["extra"] else ():
        text = text.replace(usual, hot)
    return text


AFTER_S = 0.02  # we look so long after a step is due


class Crucible:
    def __init__(self, text: str, elf: Elf | None = None) -> None:
        self.controller = spec_of(text).controller
        self.device = AvrDevice(self.controller, elf or whole(text))
        self.period_s = self.controller.loops["crucible"].period_s
        chip = self.device.sensors["tip"]
        assert isinstance(chip, SpiChip)
        self.chip: Any = chip

    def sense(self, celsius: float) -> None:
        self.device.sense("tip", celsius)

    def steps(self, count: int = 1) -> NDArray[Any]:
        done = len(self.device.steps("crucible"))
        first_s = 0 if self.device.time_s else AFTER_S
        self.device.advance(self.device.time_s + first_s + count * self.period_s)
        found: NDArray[Any] = self.device.steps("crucible")[done:]
        return found

    def read(self, count: int = 1) -> list[tuple[int, int]]:
        return [(int(s["reading_status"]), int(s["reading_raw"])) for s in self.steps(count)]

    def statuses(self, count: int = 1) -> list[int]:
        return [status for status, _ in self.read(count)]

    def answered(self, word: int) -> tuple[int, int]:
        """Let the chip answer this once; return what it is taken for."""
        self.chip._word = lambda: word
        (found,) = self.read()
        del self.chip._word
        return found


AnalogSensor = Thermistor | Rtd | Analog

NTC = "curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}"

CIRCUITS = {
    "hotend": f"kind: thermistor, pin: A1, divider: {{pull_up: 4.7 kΩ}}, {NTC}, "
    "range: 0 °C .. 300 °C, oversample: 4",
    "single": f"kind: thermistor, pin: A1, divider: {{pull_up: 4.7 kΩ}}, {NTC}, "
    "range: 0 °C .. 300 °C, oversample: 1",
    "down": f"kind: thermistor, pin: A1, divider: {{pull_down: 1 kΩ}}, {NTC}, "
    "range: 40 °C .. 280 °C, oversample: 32",
    "low_supply": f"kind: thermistor, pin: A1, divider: {{pull_up: 2.2 kΩ, supply: 3.3 V}}, {NTC}, "
    "range: 30 °C .. 250 °C, oversample: 8",
    "steinhart": "kind: thermistor, pin: A1, divider: {pull_up: 10 kΩ}, "
    "curve: {a: 1.032e-3, b: 2.387e-4, c: 1.58e-7}, range: -30 °C .. 120 °C, oversample: 4",
    "points": "kind: thermistor, pin: A1, divider: {pull_up: 4.7 kΩ}, curve: {points: "
    "[[0 °C, 327 kΩ], [25 °C, 100 kΩ], [100 °C, 6.7 kΩ], [200 °C, 560 Ω], [300 °C, 115 Ω]]}, "
    "range: 5 °C .. 280 °C, oversample: 16",
    "codes": "kind: thermistor, pin: A1, divider: {pull_up: 4.7 kΩ}, curve: {codes: "
    "[[1008, 0 °C], [985, 20 °C], [939, 40 °C], [857, 60 °C], [737, 80 °C], [591, 100 °C], "
    "[445, 120 °C], [293, 145 °C], [187, 170 °C], [109, 200 °C], [71, 225 °C], [41, 260 °C], "
    "[28, 285 °C], [23, 300 °C]]}, range: 2 °C .. 295 °C",
    "steep_codes": "kind: thermistor, pin: A1, divider: {pull_up: 4.7 kΩ}, curve: {readings: 16, "
    "codes: [[13, 860 °C], [290, 299 °C], [4637, 137 °C], [13011, 71 °C], [15779, 22 °C], "
    "[16161, -11 °C]]}, range: -5 °C .. 500 °C, oversample: 5",
    "rising_codes": "kind: thermistor, pin: A1, divider: {pull_down: 2.2 kΩ, supply: 3.3 V}, "
    "reference: 4 V, curve: {readings: 4, codes: [[600, 10 °C], [1500, 90 °C], [3000, 200 °C]]}, "
    "range: 12 °C .. 180 °C, oversample: 3",
    "ptc": "kind: thermistor, pin: A1, divider: {pull_up: 2.2 kΩ}, curve: {points: "
    "[[-40 °C, 567 Ω], [0 °C, 815 Ω], [25 °C, 1 kΩ], [100 °C, 1.696 kΩ], [150 °C, 2.26 kΩ]]}, "
    "range: -30 °C .. 140 °C, oversample: 4",
    "feeder": "kind: rtd, pin: A1, element: pt100, reference: 3.3 V, "
    "amplifier: {gain: 33.33, excitation: 3.3 V, series: 3.3 kΩ}, "
    "range: 2 °C .. 262 °C, oversample: 16",
    "frost": "kind: rtd, pin: A1, element: pt1000, divider: {pull_up: 1 kΩ}, "
    "range: -150 °C .. 150 °C, oversample: 4",
    "pt100_down": "kind: rtd, pin: A1, element: pt100, divider: {pull_down: 100 Ω}, "
    "range: 0 °C .. 600 °C, oversample: 8",
    "linear": "kind: rtd, pin: A1, element: pt1000, alpha: 3925 ppm/K, divider: {pull_up: 2 kΩ}, "
    "range: -10 °C .. 400 °C, oversample: 16",
    "linear_amplified": "kind: rtd, pin: A1, element: pt100, alpha: 3850 ppm/K, reference: 3.3 V, "
    "amplifier: {gain: 33.33, excitation: 3.3 V, series: 3.3 kΩ}, "
    "range: 2 °C .. 250 °C, oversample: 16",
    "bridge": "kind: rtd, pin: A1, element: pt1000, reference: 4 V, "
    "amplifier: {gain: 13, excitation: 5 V, series: 10 kΩ, feed: resistors}, "
    "range: 2 °C .. 190 °C, oversample: 16",
    "bridge_of_low_gain": "kind: rtd, pin: A1, element: pt100, alpha: 3850 ppm/K, "
    "amplifier: {gain: 1, excitation: 4 V, series: 470 Ω, feed: resistors}, "
    "range: 5 °C .. 400 °C, oversample: 16",
    "lm35": "kind: analog, pin: A1, scale: 10 mV/K, reference: internal, "
    "range: 2 °C .. 100 °C, oversample: 8",
    "tmp36": "kind: analog, pin: A1, scale: 10 mV/K, offset: 500 mV, reference: 3.3 V, "
    "open_reads: high, range: -40 °C .. 125 °C, oversample: 4",
    "falling": "kind: analog, pin: A1, scale: -10 mV/K, offset: 4 V, "
    "range: 0 °C .. 150 °C, oversample: 2",
}
"""By a name of the tests; what a spec says of the sensor."""

BED = """
heatwright: 1
controller: {name: bed, board: BOARD}
sensors:
  bed: {SENSOR}
outputs:
  heater: {kind: pwm, pin: D3, frequency: 490 Hz, power: 120 W}
loops:
  bed:
    sensor: bed
    heater: heater
    period: 200 ms
    setpoint: {initial: 50 °C, minimum: 45 °C, maximum: 70 °C}
    algorithm: {kind: pid, kp: 12, ki: 0.1, kd: 60, derivative_filter: 2 s}
    protection:
      maximum: 85 °C
      minimum: 10 °C
      rise_rate: 15 K/s
      heating: {rise: 2 K, within: 60 s}
      runaway: {above: 10 K, below: 10 K, for: 60 s}
      stale_after: 1 s
safety: {watchdog: 1 s, self_checks: false}
interfaces:
  - {INTERFACE}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {plate: 300 J/K}
    links:
      - {between: [plate, ambient], resistance: 1.1 K/W}
    heat: {heater: plate}
    bears: {plate: 100 °C}
    sense: {bed: {node: plate, lag: 4 s}}
  scenario:
    - {for: 300 s}
"""
KEYS = "kind: lcd_keypad, loop: bed, step: 5 K"
PLOTTER = "kind: serial_plotter, loop: bed, baud: 115200"
ON_THE_BED = {"thermistor": "hotend", "rtd": "frost", "analog": "tmp36"}
"""A circuit of each kind that can stand on this machine."""


@cache
def sensor(name: str) -> AnalogSensor:
    written = yaml.safe_load(f"{{{CIRCUITS[name]}}}")
    made: AnalogSensor = TypeAdapter(Sensor).validate_python(written)
    return made


def bed(circuit: str, *, board: str = "uno", interface: str = PLOTTER) -> str:
    text = BED.replace("BOARD", board).replace("SENSOR", CIRCUITS[circuit])
    return text.replace("INTERFACE", interface)


def powered(text: str, elf: Elf | None = None) -> AvrDevice:
    """Power the machine on at 50 °C; with another binary if there is one."""
    return device_of(text, 50.0, elf)


LOOP = """
  {0}:
    sensor: {0}
    heater: of_{0}
    period: 200 ms
    setpoint: {{initial: 50 °C, minimum: 45 °C, maximum: 70 °C}}
    algorithm: {{kind: pid, kp: 12, ki: 0.1}}
    protection: {{minimum: 10 °C, rise_rate: 15 K/s}}"""
TWO = f"""
heatwright: 1
controller: {{name: two, board: mega2560}}
sensors: {{bed: {{{CIRCUITS["hotend"]}}}, far: {{{CIRCUITS["hotend"].replace("A1", "A13")}}}}}
outputs:
  of_bed: {{kind: pwm, pin: D3, frequency: 490 Hz, power: 120 W}}
  of_far: {{kind: pwm, pin: D5, frequency: 490 Hz, power: 120 W}}
loops:{LOOP.format("bed")}{LOOP.format("far")}
"""
"""On ADC1 and, through MUX5, ADC13."""
