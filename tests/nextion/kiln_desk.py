"""The kiln with its display, in a test's hands."""

import re
from functools import cache
from typing import Any

from rig.avr import whole
from rig.specs import controller_of, sources_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.spec import Controller

IDLE, RUNNING, PAUSED, RETURNING = range(4)
"""States of a program."""
DISPLAY_FILES = sorted(name for name in sources_of("kiln") if re.fullmatch(r"nextion\w*\.c", name))
"""Source files whose variables are the display's own."""
ROOM_C = 20.0


@cache
def firmware(spec: str) -> tuple[Controller, Elf]:
    """Return a controller (a spec's text, or an example's name) and what it runs."""
    return controller_of(spec), whole(spec)


class KilnDesk:
    """A kiln at the temperature of the room that is powered on, with its display on its line.

    device -- the board.
    """

    def __init__(self, spec: str = "kiln") -> None:
        self.controller, program = firmware(spec)
        self.device = AvrDevice(self.controller, program)

    @property
    def display(self) -> Nextion:
        return self.device.display

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.device.sense("chamber", ROOM_C)
        self.device.advance(self.device.time_s + seconds)
        self.device.feed()

    def tap(self, *names: str) -> None:
        """Touch one component after the other, with time for the board to answer."""
        for name in names:
            self.display.tap(name)
            self.run(0.6)

    def do(self, deeds: str) -> None:
        """Do what stands there between semicolons, with time for what comes of it.

        `enter 12.5` in place of what is shown, `order 2 1`, `wait 30` (seconds), `power` (cut and
        given back); `wire S`, `break` and `mend` the thermocouple; all other words are touched.
        """
        for deed in deeds.split("; "):
            verb, _, rest = deed.partition(" ")
            match verb:
                case "enter":
                    keys = {key: f"d{place}" for place, key in enumerate("789456123.0-")}
                    self.tap("clear", *(keys[character] for character in rest), "ok")
                case "order":
                    self.display.send(f"#{rest};")
                case "wait":
                    self.run(float(rest))
                case "power":
                    self.device.power_cycle()
                    self.run(2.0)
                case "wire":
                    self.device.sensors["chamber"].wire = rest
                case "break" | "mend":
                    self.device.sensors["chamber"].faults.open = verb == "break"
                case _:
                    self.tap(*deed.split())
        self.run(2.0)

    def look(self, name: str) -> Any:
        """Return the page that is shown, a row of a program, a variable, or what a field shows."""
        if name == "page":
            return self.display.page
        if name.startswith("row"):
            return " ".join(self.look(f"{column}{name[3:]}.txt") for column in "kmt").strip()
        shown = name.endswith((".txt", ".val", ".en"))
        return self.display.value(name) if shown else self.device.read(name).item()
