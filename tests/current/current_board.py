"""A heater whose current is measured, with that current in the test's hand."""

import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from heatwright.generator import plan_firmware, render
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.reference.current import Converter
from heatwright.sim.sensors.current import CurrentProbe
from heatwright.spec import CurrentSensor, Spec, load_text

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
BOARDS = {
    "uno": "kind: ds18b20, pin: D2",
    "mega2560": "kind: ds18b20, pin: D22",
}
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
FLAGS = ["-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections", "-Wall"]
FLAGS += ["-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]


class Broken(NamedTuple):
    """A line of a source, and what stands in its place."""

    file: str
    right: str
    wrong: str


def board_of(circuit: str) -> str:
    return "mega2560" if circuit == "far" else "uno"


def spec_of(circuit: str, period: str = "1 s") -> Spec:
    board = board_of(circuit)
    text = SPEC.replace("THERMOMETER", BOARDS[board]).replace("BOARD", board)
    text = text.replace("PERIOD", period).replace("SENSOR", CIRCUITS[circuit])
    return load_text(text, "measured.yaml")


@cache
def program(circuit: str, broken: Broken | None = None) -> Elf:
    """Compile the whole firmware, as strictly as a project is."""
    folder = Path(tempfile.mkdtemp(prefix="current-"))
    spec = spec_of(circuit)
    texts = {
        Path(path).name: text
        for path, text in render(plan_firmware(spec)).items()
        if path.startswith("src/")
    }
    if broken:
        assert broken.right in texts[broken.file], broken
        texts[broken.file] = texts[broken.file].replace(broken.right, broken.wrong, 1)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    board = spec.controller.board
    chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL", *(["-w"] if broken else [])]
    sources = [str(each) for each in sorted(folder.glob("*.c"))]
    elf = folder / "firmware.elf"
    link = ["-Wl,--gc-sections", "-lm", "-o", str(elf)]
    subprocess.run(["avr-gcc", *chip, *FLAGS, *sources, *link], check=True)
    return Elf(elf)


class Measured:
    """The board, run period by period."""

    def __init__(self, circuit: str, broken: Broken | None = None) -> None:
        spec = spec_of(circuit)
        self.controller = spec.controller
        self.device = AvrDevice(self.controller, program(circuit, broken))
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
