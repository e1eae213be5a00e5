"""Somebody at the keys of the kiln on an Uno, and what its two lines say."""

from typing import Any

import numpy as np
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.scenario import PRESS_S

CONTROLLER = example("kiln_uno").controller
ROOM_C = 20.0
IDLE, RUNNING, PAUSED, RETURNING = range(4)
"""States of a program."""
STEP_S = 1.2
"""After it the next control step has done what was asked for."""


class MenuDesk:
    """The kiln, powered up anew with an empty EEPROM; its thermocouple has one temperature."""

    def __init__(self, device: AvrDevice) -> None:
        self.device = device
        self.felt_c = ROOM_C
        device.avr.eeprom.contents = b"\xff" * device.avr.eeprom.size
        self._power_up()

    def _power_up(self) -> None:
        self.device.power_cycle()
        self._until_s = self.device.time_s
        self.run(2.5)

    def power_cycle(self) -> None:
        """Cut the power and give it back, and let the program start."""
        self.run(2.0)
        self._power_up()

    def run(self, seconds: float = STEP_S) -> None:
        """Go on for a time."""
        self.device.sense("chamber", self.felt_c)
        self._until_s += seconds
        self.device.advance(self._until_s)

    def warm_to(self, celsius: float) -> None:
        """Let the chamber warm up, not so fast that the protection `rise_rate` trips."""
        while self.felt_c < celsius:
            self.felt_c += 4.0
            self.run(1.0)

    def press(self, *keys: str, for_s: float = PRESS_S) -> tuple[str, str]:
        """Press keys one after the other; return what is shown then."""
        for key in keys:
            self.device.press(key)
            self.run(for_s)
            self.device.press(None)
            self.run(min(for_s, PRESS_S))
        return self.lines

    def walk(self, *steps: tuple[str, str, str]) -> None:
        """Press the keys of each step, and see both lines after them."""
        for keys, *lines in steps:
            assert list(self.press(*keys.split())) == lines, keys

    @property
    def lines(self) -> tuple[str, str]:
        """What is shown, without the blanks behind it."""
        first, second = self.device.shield.lcd.text
        return first.rstrip(), second.rstrip()

    def read(self, name: str) -> Any:
        """Read a variable of the firmware."""
        return self.device.read(name).item()

    def put(self, name: str, value: float) -> None:
        """Set a variable of the firmware."""
        variable = self.device.variables[name]
        self.device.avr.write_ram(variable.address, np.asarray(value, variable.dtype).tobytes())

    def program(self, member: str) -> Any:
        """Read a member of the program's state."""
        return self.read(f"program.{member}")

    def go_to(self, title: str) -> tuple[str, str]:
        """Go to one of the values, from the first screen."""
        self.press("left")
        for _ in range(20):
            if self.lines[0] == title:
                break
            self.press("select")
        return self.lines
