"""Somebody at the keys of the kiln on an Uno, and what its two lines say."""

from __future__ import annotations

from typing import Any

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.scenario import PRESS_S
from heatwright.spec import Controller

ROOM_C = 20.0
DEGREE = "°"


class MenuDesk:
    """The kiln, powered; its thermocouple is held at one temperature."""

    def __init__(self, controller: Controller, elf: Elf) -> None:
        self.device = AvrDevice(controller, elf)
        self.felt_c = ROOM_C
        self._until_s = 0.0

    def run(self, seconds: float) -> None:
        """Go on for a time."""
        self.device.sense("chamber", self.felt_c)
        self._until_s += seconds
        self.device.advance(self._until_s)

    def press(self, *keys: str) -> tuple[str, str]:
        """Press keys one after the other; return what is shown then."""
        for key in keys:
            self.device.press(key)
            self.run(PRESS_S)
            self.device.press(None)
            self.run(PRESS_S)
        return self.lines

    def hold(self, key: str, seconds: float) -> tuple[str, str]:
        """Hold a key down for a time."""
        self.device.press(key)
        self.run(seconds)
        self.device.press(None)
        self.run(PRESS_S)
        return self.lines

    @property
    def lines(self) -> tuple[str, str]:
        """What is shown, without the blanks behind it."""
        first, second = self.device.shield.lcd.text
        return first.rstrip(), second.rstrip()

    def program(self, member: str) -> Any:
        """Return a member of the program's state."""
        return self.device.read(f"program.{member}").item()

    def power_cycle(self) -> None:
        """Cut the power and give it back, and let the program start."""
        self.run(2.0)
        self.device.power_cycle()
        self.run(2.5)
