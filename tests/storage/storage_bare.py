"""A controller with its sensor, its heater and its relay, and nobody at its display or its keys."""

from importlib import import_module
from typing import Any

import numpy as np

from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variable, Variables
from heatwright.sim.elf import Elf
from heatwright.sim.relay import SafetyRelay
from heatwright.spec import Controller, LcdKeypad

LOOP = "chamber"


class Names:
    """The variables of a program, each looked up once."""

    def __init__(self, program: Elf) -> None:
        self._variables = Variables(program)
        self._found: dict[str, Variable] = {}

    def read(self, avr: Avr, name: str) -> Any:
        if name not in self._found:
            self._found[name] = self._variables[name]
        at = self._found[name]
        return np.frombuffer(avr.read_ram(at.address, at.size), at.dtype)[0]

    def address(self, name: str) -> int:
        return self._variables[name].address


class Bare:
    """Powered up again and again, each time with another EEPROM."""

    def __init__(self, controller: Controller, program: Elf) -> None:
        self.names = Names(program)
        self._controller, self._program = controller, program

    def power_up(self, image: bytes, felt_c: float) -> None:
        controller, board = self._controller, self._controller.board
        self.avr = Avr(board.mcu, board.clock_hz)
        self.avr.load(self._program)
        self.avr.eeprom.contents = image
        loop = controller.loops[LOOP]
        sensor, heater = controller.sensors[loop.sensor], controller.outputs[loop.heater]
        self._sensor = _simulated("sensors", sensor.kind).attach(self.avr, board, sensor)
        self._heater = _simulated("outputs", heater.kind).attach(self.avr, board, heater)
        relay = controller.outputs[str(controller.safety.relay)]
        self._contact = _simulated("outputs", relay.kind).attach(self.avr, board, relay)
        self._relay = SafetyRelay()
        self._relay.power_on(self.avr, controller)
        self._keys = [
            _simulated("interfaces", each.kind).attach(self.avr, board, each)
            for each in controller.interfaces
            if isinstance(each, LcdKeypad)
        ]
        self._sensor.sense(felt_c)

    @property
    def time_s(self) -> float:
        return self.avr.time_s

    def advance(self, seconds: float) -> None:
        self.avr.run(seconds)

    def read(self, name: str) -> Any:
        return self.names.read(self.avr, name)

    def heated(self) -> bool:
        """Whether the heater's pin was active since the last call."""
        return bool(self._heater.on_fraction() > 0)


def _simulated(folder: str, kind: str) -> Any:
    return import_module(f"heatwright.sim.{folder}.{kind}")
