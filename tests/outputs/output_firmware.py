"""The generated outputs, clock and reset alone, with a program of the test's around them."""

import hashlib
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from heatwright.generator import plan_firmware, render
from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.elf import Elf
from heatwright.spec import Controller, load_text

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]
FLAGS = ["-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections"]
FLAGS += ["-Wl,--gc-sections", *WARNINGS]

SPEC = """
heatwright: 1
controller: {{name: outputs, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs:
  {outputs}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {{initial: 0 °C, minimum: 0 °C, maximum: 70 °C}}
    algorithm: {{kind: pid, kp: 10, ki: 0.1}}
    ready_within: 1 K
interfaces: [{{kind: gcode, loops: {{T0: air}}, fans: {{{fans}}}, steppers: {{{steppers}}}}}]
"""

PINS = {
    "uno": ("A1", "D2"),
    "nano": ("A1", "D2"),
    "leonardo": ("A1", "D2"),
    "mega2560": ("A1", "D22"),
    "atmega328p": ("PC1", "PD2"),
    "atmega2560": ("PF1", "PA0"),
    "atmega1284p": ("PA1", "PA2"),
    "atmega32": ("PA1", "PA2"),
    "atmega16": ("PA1", "PA2"),
}
"""A sensor's and a heater's, of no interest to the test."""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "config.h"
#include "fault.h"
#include "gate.h"
#include "loop_air.h"
#include "pins.h"
"""

Outputs = Mapping[str, str]
"""What the file says of each output, by its name. `heater` is the loop's; the host commands the
others."""


def text_of(board: str, outputs: Outputs) -> str:
    """Write the spec."""
    sensor, pin = PINS[board]
    heater = f"kind: time_proportional, window: 1 s, pin: {pin}, power: 40 W"
    every = {"heater": heater} | dict(outputs)
    others = [name for name in outputs if name != "heater"]
    fans = [name for name in others if "stepper" not in outputs[name]]
    steppers = [name for name in others if name not in fans]
    return SPEC.format(
        board=board,
        sensor=sensor,
        outputs="\n  ".join(f"{name}: {{{said}}}" for name, said in every.items()),
        fans=", ".join(f"P{number}: {name}" for number, name in enumerate(fans)),
        steppers=", ".join(f"E: {name}" for name in steppers),
    )


def controller_of(board: str, outputs: Outputs) -> Controller:
    """Read the spec."""
    return load_text(text_of(board, outputs), "spec.yaml").controller


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="output-firmware-"))


def sources_of(board: str, outputs: Outputs, *others: str) -> dict[str, str]:
    """Print the headers, the outputs asked for, the clock and other sources of the firmware."""
    plan = plan_firmware(load_text(text_of(board, outputs), "spec.yaml"))
    wanted = {f"src/{name}.c" for name in ("clock", *others)}
    wanted |= {f"src/output_{name}.c" for name in outputs}
    chosen = [each for each in plan.files if each.path in wanted or each.path.endswith(".h")]
    files = render(replace(plan, files=tuple(chosen)))
    return {path.removeprefix("src/"): text for path, text in files.items()}


class Broken(NamedTuple):
    """A line of an output's C, and what stands in its place."""

    output: str
    right: str
    wrong: str


def program(
    board: str, outputs: Outputs, main: str, *others: str, broken: Broken | None = None
) -> Elf:
    """Compile them with a main program, as strictly as a project is."""
    texts = sources_of(board, outputs, *others) | {"main.c": MAIN + main}
    if broken:
        file = f"output_{broken.output}.c"
        assert broken.right in texts[file]
        texts[file] = texts[file].replace(broken.right, broken.wrong, 1)
    name = hashlib.sha256(repr((board, sorted(texts.items()))).encode()).hexdigest()[:16]
    folder = _folder() / name
    elf = folder / "firmware.elf"
    if not elf.exists():
        folder.mkdir(exist_ok=True)
        for path, text in texts.items():
            (folder / path).write_text(text, encoding="utf-8")
        made = controller_of(board, outputs).board
        chip = [f"-mmcu={made.mcu}", f"-DF_CPU={made.clock_hz}UL"]
        files = [path for path in texts if path.endswith(".c")]
        command = ["avr-gcc", *chip, *FLAGS, *(["-w"] * bool(broken)), *files, "-lm", "-o", elf]
        subprocess.run(command, cwd=folder, check=True)
    return Elf(elf)


class Board:
    """A processor that runs such a program, whose variables can be read and set."""

    def __init__(self, elf: Elf, controller: Controller) -> None:
        self.board = controller.board
        self.avr = Avr(self.board.mcu, self.board.clock_hz)
        self.avr.load(elf)
        self._variables = Variables(elf)

    def put(self, name: str, value: float) -> None:
        """Set a variable of the program."""
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype).tobytes())

    def get(self, name: str) -> Any:
        """Read a variable of the program."""
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        return np.frombuffer(raw, variable.dtype)[0]
