"""The kiln with its display and its machine, in a test's hands."""

import re
from functools import cache
from typing import Any

from rig.avr import whole
from rig.specs import controller_of, sources_of

from heatwright.sim.bench import step_of
from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.plants import plant_of
from heatwright.spec import Controller

IDLE, RUNNING, PAUSED, RETURNING = range(4)
"""States of a program."""
DISPLAY_FILES = sorted(name for name in sources_of("kiln") if re.fullmatch(r"nextion\w*\.c", name))
"""Source files whose variables are the display's own."""
ROOM_C = 20.0
STEP_S = 0.1


@cache
def firmware(spec: str) -> tuple[Controller, Elf]:
    """Return a controller (a spec's text, or an example's name) and what it runs."""
    return controller_of(spec), whole(spec)


class KilnDesk:
    """A kiln that is powered on; device -- the board, display -- on its line.

    Its machine is the one of its spec; without one it stays at the temperature of the room.
    """

    def __init__(self, spec: str = "kiln") -> None:
        self.controller, program = firmware(spec)
        self.device = AvrDevice(self.controller, program)
        self._rows, self._begin_s = 0, 0.0
        self._step_s, self._plant = STEP_S, None
        if simulation := self.controller.simulation:
            self._step_s = step_of(self.controller)
            self._plant = plant_of(self.controller, simulation.plant, seed=0,
                                   ambient_c=simulation.ambient_c, step_s=self._step_s)  # fmt: skip
            self._coupling = Coupling(self.controller, self.device, self._step_s)

    @property
    def display(self) -> Nextion:
        return self.device.display

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / self._step_s)):
            felt_c = self._plant.sensed_c() if self._plant else {"chamber": ROOM_C}
            for sensor, felt in felt_c.items():
                self.device.sense(sensor, felt)
            self._rows += 1
            self.device.advance(self._begin_s + self._rows * self._step_s)
            if self._plant:
                self._plant.step(self._coupling.supplied(self._coupling.active()), 0.0)
        self.device.feed()

    def tap(self, *names: str) -> None:
        """Touch one component after the other, with time for the board to answer."""
        for name in names:
            self.display.tap(name)
            self.run(0.6)

    def read(self, name: str) -> Any:
        return self.device.read(name).item()

    def shows(self, attribute: str) -> int | str:
        return self.display.value(attribute)

    def power_cycle(self) -> None:
        """Cut the power and give it back."""
        self.device.power_cycle()
        self._coupling = Coupling(self.controller, self.device, self._step_s)
        self._begin_s, self._rows = self.device.time_s, 0
        self.run(2.0)

    def do(self, deeds: str) -> None:
        """Do what stands there between semicolons, with time for what comes of it.

        `enter 12.5`, `order 2 1`, `wait 30` (seconds), `power` (cut and given back); `wire S`,
        `break` and `mend` the thermocouple; all other words are touched.
        """
        for deed in deeds.split("; "):
            verb, _, rest = deed.partition(" ")
            match verb:
                case "enter":
                    self.enter(rest)
                case "order":
                    self.display.send(f"#{rest};")
                case "wait":
                    self.run(float(rest))
                case "power":
                    self.power_cycle()
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
            return " ".join(str(self.shows(f"{column}{name[3:]}.txt")) for column in "kmt").strip()
        return self.shows(name) if name.endswith((".txt", ".val", ".en")) else self.read(name)

    def enter(self, text: str) -> None:
        """Key a number into the pages that ask for one, in place of what they show."""
        keys = {key: f"d{place}" for place, key in enumerate("789456123.0-")}
        self.tap("clear", *(keys[character] for character in text), "ok")
