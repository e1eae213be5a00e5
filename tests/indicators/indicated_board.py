"""A small oven whose loop is shown by LEDs, with its temperature and current in the test's hand."""

import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from heatwright.generator import plan_firmware, render
from heatwright.sim.circuits import Wiring
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.indicators import Indicators, Light
from heatwright.spec import Spec, load_text

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
FLAGS = ["-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections", "-Wall"]
FLAGS += ["-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror", "-mmcu=atmega328p"]
FLAGS += ["-DF_CPU=16000000UL"]

FULL_A = 76.6 / 43
STEP_S = 0.1
FASTEST_K = 10.0
"""Change of the temperature in a step; `rise_rate` allows twice that."""
SETTLED_S = 4.0
"""A step of the loop or some, the current's soft start, and two seconds of looking."""


class Broken(NamedTuple):
    """A line of the indicators' C, and what stands in its place."""

    right: str
    wrong: str


def spec_of(interfaces: str = LEDS, active: str = "high") -> Spec:
    lost = ", master_lost_after: 3 s" if "LOST" in interfaces else ""
    text = SPEC.replace("PROTECTION", PROTECTION + lost + "}")
    interfaces = interfaces.replace("ACTIVE", active).replace("# LOST\n", "")
    return load_text(text + interfaces, "shown.yaml")


def _compile(source: Path, made: Path, *flags: str) -> Path:
    command = ["avr-gcc", *FLAGS, *flags, "-c", str(source), "-o", str(made)]
    subprocess.run(command, check=True)
    return made


@cache
def _project(interfaces: str, active: str) -> Path:
    folder = Path(tempfile.mkdtemp(prefix="indicators-"))
    for path, text in render(plan_firmware(spec_of(interfaces, active))).items():
        if path.startswith("src/"):
            (folder / Path(path).name).write_text(text, encoding="utf-8")
    for source in folder.glob("*.c"):
        _compile(source, source.with_suffix(".o"))
    return folder


def program(interfaces: str = LEDS, active: str = "high", broken: Broken | None = None) -> Elf:
    """Compile the whole firmware, as strictly as a project is."""
    folder = _project(interfaces, active)
    objects = [str(each) for each in sorted(folder.glob("*.o"))]
    elf = folder / "firmware.elf"
    if broken:
        text = (folder / "indicators_block.c").read_text("utf-8")
        assert broken.right in text, broken
        place = Path(tempfile.mkdtemp(prefix="broken-", dir=folder))
        changed = place / "indicators_block.c"
        changed.write_text(text.replace(broken.right, broken.wrong, 1), encoding="utf-8")
        made = _compile(changed, place / "changed.o", "-w", f"-I{folder}")
        objects = [each for each in objects if not each.endswith("/indicators_block.o")]
        objects.append(str(made))
        elf = place / "firmware.elf"
    link = ["avr-gcc", *FLAGS, "-Wl,--gc-sections", *objects, "-lm", "-o", str(elf)]
    subprocess.run(link, check=True)
    return Elf(elf)


class Shown:
    """The board, its sensors fed by hand; `strength` is the heater's current, in its own."""

    def __init__(self, elf: Elf, interfaces: str = LEDS, active: str = "high") -> None:
        self.device = AvrDevice(spec_of(interfaces, active).controller, elf)
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
