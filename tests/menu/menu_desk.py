"""Somebody at the keys of the kiln on an Uno, and what its two lines say."""

from typing import Any

import numpy as np
import pytest
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.scenario import PRESS_S

CONTROLLER = example("kiln_uno").controller
ROOM_C = 20.0
STATES = {"idle": 0, "running": 1, "paused": 2, "returning": 3}
"""Of a program."""
STEP_S = 1.2
"""After it the next control step has done what was asked for."""


def scripts_of(text: str) -> dict[str, str]:
    """Return scripts by their names, which stand before them behind a #."""
    return dict(map(str.strip, each.split("\n", 1)) for each in text.split("# ")[1:])  # type: ignore[misc]


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

    def play(self, script: str) -> None:
        """Do what each line says, and see what stands behind its arrow.

        Before it are keys, `up:5` for one that is held so many seconds, `wait:5`, `step` until the
        next control step is done, `power` cut and given back. Behind it are both lines that are
        shown, `title | text`, of which one may be left out, or variables, `state=idle`.
        """
        for line in filter(None, map(str.strip, script.splitlines())):
            words, _, seen = line.partition("->")
            for word in words.split():
                self._do(*word.split(":"))
            if "|" in seen:
                wanted = [each.strip() for each in seen.split("|")]
                found = [now if each else "" for now, each in zip(self.lines, wanted, strict=True)]
                assert found == wanted, line
            else:
                for name, value in (each.split("=") for each in seen.split()):
                    known = self.read(name) if "." in name else self.program(name)
                    assert known == pytest.approx(float(STATES.get(value, value))), line

    def _do(self, word: str, seconds: str = "") -> None:
        match word:
            case "wait":
                self.run(float(seconds))
            case "step":
                self.run()
            case "power":
                self.power_cycle()
            case key:
                self.press(key, for_s=float(seconds or PRESS_S))

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
