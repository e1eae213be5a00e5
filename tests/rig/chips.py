"""A firmware with a crucible, whose temperature a converter on SPI wires measures."""

from typing import Any

from numpy.typing import NDArray
from rig.firmware import spec_of, whole

from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.sensors.spi_chip import SpiChip

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
      runaway: {{above: 15 K, below: 15 K, for: 20 s}}
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
    "maximum: 250 °C": "maximum: 650 °C",
    "minimum: -30 °C": "minimum: 260 °C",
    "maximum: 285 °C": "maximum: 700 °C",
    "ambient: 20 °C": "ambient: 280 °C",
}
"""For type B, which measures nothing below 250 °C."""


def crucible(kind: str, board: str = "uno", *, period_s: float = 0, **said: str) -> str:
    """Write the spec of a crucible under PID with a converter.

    `clock` and `extra` are what more the file says of the controller and of the converter, `more`
    are further sections.
    """
    select, sck, out, into, heater = PINS[board]
    wires = f"chip_select: {select}, clock: {sck}, data_out: {out}"
    wires += f", data_in: {into}" if kind == "max31856" else ""
    given = {"kind": kind, "board": board, "wires": wires, "heater": heater}
    given |= {"clock": "", "extra": "", "more": "", "minimum": MINIMUM[kind]} | said
    text = CRUCIBLE.format(period_ms=1000 * (period_s or PERIOD_S[kind]), **given)
    for usual, hot in HOTTER.items() if "thermocouple: B" in given["extra"] else ():
        text = text.replace(usual, hot)
    return text


AFTER_S = 0.02
"""We look so long after a step is due."""


class Crucible:
    """The crucible's board, run period by period."""

    def __init__(self, text: str, elf: Elf | None = None) -> None:
        """Power on; with another binary if there is one."""
        self.controller = spec_of(text).controller
        self.device = AvrDevice(self.controller, elf or whole(text))
        self.period_s = self.controller.loops["crucible"].period_s
        chip = self.device.sensors["tip"]
        assert isinstance(chip, SpiChip)
        self.chip: Any = chip

    def sense(self, celsius: float) -> None:
        """Set the tip's temperature."""
        self.device.sense("tip", celsius)

    def steps(self, count: int = 1) -> NDArray[Any]:
        """Run so many periods, and return their steps."""
        done = len(self.device.steps("crucible"))
        first_s = 0 if self.device.time_s else AFTER_S
        self.device.advance(self.device.time_s + first_s + count * self.period_s)
        found: NDArray[Any] = self.device.steps("crucible")[done:]
        return found

    def read(self, count: int = 1) -> list[tuple[int, int]]:
        return [(int(s["reading_status"]), int(s["reading_raw"])) for s in self.steps(count)]

    def statuses(self, count: int = 1) -> list[int]:
        """Do the same, and return each step's status."""
        return [status for status, _ in self.read(count)]

    def answered(self, word: int) -> tuple[int, int]:
        """Let the chip answer this once; return what it is taken for."""
        self.chip._word = lambda: word
        (found,) = self.read()
        del self.chip._word
        return found
