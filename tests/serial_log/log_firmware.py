"""The log by itself: a program that lets a test say what the loop reads."""

import hashlib
import subprocess
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from heatwright.generator import plan_firmware, render
from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.serial_log import SerialLog, attach
from heatwright.spec import Controller, load_text
from heatwright.spec import SerialLog as Spec

FLAGS = ["-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections"]
FLAGS += ["-Wl,--gc-sections", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic"]

SPEC = """
heatwright: 1
controller: {{name: logged, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs: {{heater: {{kind: digital, pin: {heater}, power: 40 W}}}}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {{initial: 10 °C, minimum: 0 °C, maximum: 70 °C}}
    algorithm: {{kind: on_off, hysteresis: 2 K}}
interfaces: [{{kind: serial_log, loop: air, {said}}}]
"""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "gate.h"
#include "log.h"
#include "log_port.h"
#include "loop_air.h"
#if EEPROM
#include "log_ring_eeprom.h"
#endif

struct loop_air_state loop_air;
volatile uint16_t passes;
volatile uint8_t deaf_ms; /* so that several ticks come at once */

void gate_tick(void)
{
}

int main(void)
{
#if EEPROM
    log_ring_start();
#endif
    log_port_start();
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        for (; deaf_ms != 0; deaf_ms--) {
            __builtin_avr_delay_cycles(F_CPU / 1000UL);
        }
        passes++;
        log_tick();
#if EEPROM
        log_ring_tick();
#endif
    }
}
"""
BOARDS = {
    "uno": {"sensor": "A1", "heater": "D3"},
    "mega2560": {"sensor": "D22", "heater": "D6"},
    "atmega32": {"sensor": "PA2", "heater": "PD5"},
}
TICK_S = 0.01


class Broken(NamedTuple):
    """A line of the C, and what stands in its place."""

    file: str
    right: str
    wrong: str


def controller_of(board: str, said: str) -> Controller:
    return load_text(_text(board, said), "spec.yaml").controller


def _text(board: str, said: str) -> str:
    return SPEC.format(board=board, said=said, **BOARDS[board])


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="log-firmware-"))


def program(board: str, said: str, broken: Broken | None) -> Elf:
    """Compile clock and log with the program above, as strictly as a project is."""
    plan = plan_firmware(load_text(_text(board, said), "spec.yaml"))
    chosen = [
        file
        for file in plan.files
        if file.path.endswith(".h") or file.path.startswith(("src/clock", "src/log"))
    ]
    printed = render(replace(plan, files=tuple(chosen)))
    texts = {path.removeprefix("src/"): text for path, text in printed.items()} | {"main.c": MAIN}
    if broken:
        assert broken.right in texts[broken.file], broken
        texts[broken.file] = texts[broken.file].replace(broken.right, broken.wrong, 1)
    name = hashlib.sha256(repr((board, sorted(texts.items()))).encode()).hexdigest()[:16]
    folder = _folder() / name
    elf = folder / "firmware.elf"
    if not elf.exists():
        folder.mkdir(exist_ok=True)
        for path, text in texts.items():
            (folder / path).write_text(text, encoding="utf-8")
        made = controller_of(board, said).board
        chip = [f"-mmcu={made.mcu}", f"-DF_CPU={made.clock_hz}UL"]
        chip.append(f"-DEEPROM={int('log_ring_eeprom.h' in texts)}")
        files = [path for path in texts if path.endswith(".c")]
        strict = ["-w"] if broken else ["-Werror"]
        command = ["avr-gcc", *chip, *FLAGS, *strict, *files, "-lm", "-o", str(elf)]
        subprocess.run(command, cwd=folder, check=True)
    return Elf(elf)


class LogBoard:
    """A processor that runs it, the computer that reads it, and what it should say."""

    def __init__(
        self,
        board: str = "uno",
        said: str = "every: 2 s, entries: 20",
        broken: Broken | None = None,
        eeprom: bytes = b"",
    ) -> None:
        self._made = board, said, broken
        self.broken = broken
        self.controller = controller_of(board, said)
        (interface,) = self.controller.interfaces
        assert isinstance(interface, Spec)
        self.interface = interface
        self.elf = program(board, said, broken)
        self._variables = Variables(self.elf)
        made = self.controller.board
        self.avr = Avr(made.mcu, made.clock_hz)
        self.avr.load(self.elf)
        if eeprom:
            self.avr.eeprom.contents = eeprom
        self.computer: SerialLog = attach(self.avr, made, interface)
        self.avr.run(TICK_S / 2)
        self.reads(0.0)

    def after_power_cut(self, undefined: int = 0xFF) -> "LogBoard":
        """Return the same board with the EEPROM as a loss of power leaves it now."""
        return LogBoard(*self._made, self.avr.eeprom.after_power_cut(undefined))

    def put(self, name: str, value: float) -> None:
        """Set a variable of the program."""
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype).tobytes())

    def get(self, name: str) -> Any:
        """Read a variable of the program."""
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        return np.frombuffer(raw, variable.dtype)[0]

    def reads(self, temperature_c: float | None, setpoint_c: float = 20.0) -> None:
        """Let the loop read this from now on; None: nothing."""
        self.put("loop_air.has_reading", 1)
        self.put("loop_air.missing", int(temperature_c is None))
        if temperature_c is not None:
            self.put("loop_air.temperature_c", temperature_c)
        self.put("loop_air.setpoint_c", setpoint_c)

    def run(self, seconds: float) -> None:
        """Go on, and let the computer hear."""
        self.avr.run(seconds)
        self.computer.feed(self.avr.pins.take(), self.avr.uarts.take())

    def ask(self, command: str, seconds: float = 1.0) -> list[str]:
        """Send a command and return the lines that came."""
        self.computer.write(command)
        self.run(seconds)
        return self.computer.texts
