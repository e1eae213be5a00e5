"""Where machines are tried, well or broken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from heatwright.sim.binary.elf import Elf
from heatwright.sim.interfaces.gcode import heats
from heatwright.spec import (
    Controller,
    Loop,
    ThermalNetwork,
    commanded,
    gcode_of,
    modbus_of,
    programmed,
    switched,
)
from heatwright.spec.commands import keyed, keypad_of, touched


@dataclass(frozen=True)
class Place:
    """A controller on its machine, and the loop in question."""

    controller: Controller
    loop_name: str

    @property
    def loop(self) -> Loop:
        """The loop in question."""
        return self.controller.loops[self.loop_name]

    @property
    def network(self) -> ThermalNetwork:
        """The machine as specified; raises ValueError when there is none."""
        if self.controller.simulation is None:
            raise ValueError("Faults need a machine: the specification has no `simulation`.")
        return self.controller.simulation.plant

    @property
    def ambient_c(self) -> float:
        """The temperature of the surroundings as specified, °C."""
        simulation = self.controller.simulation
        return simulation.ambient_c if simulation else 20.0

    @property
    def has_keys(self) -> bool:
        """Whether there is somebody to press UP, DOWN and SELECT."""
        return keypad_of(self.controller) is not None

    @property
    def has_menu(self) -> bool:
        """Whether the keys lead through a menu, as they do where programs run."""
        return keyed(self.controller, self.loop_name) and programmed(
            self.controller, self.loop_name
        )

    @property
    def has_keys_alone(self) -> bool:
        """Whether UP and DOWN are all that sets the setpoint, step by step."""
        others = modbus_of(self.controller) or touched(self.controller, self.loop_name)
        return self.is_switched and not others

    @property
    def is_commanded(self) -> bool:
        """Whether a host, a master, a display or keys command the loop; they operate it then."""
        return commanded(self.controller, self.loop_name)

    @property
    def is_switched(self) -> bool:
        """Whether a master, a display or keys switch the loop on and off."""
        return switched(self.controller, self.loop_name)

    @property
    def is_hosted(self) -> bool:
        """Whether a host commands the loop by G-code."""
        return self.is_commanded and not self.is_switched

    @property
    def has_operator(self) -> bool:
        """Whether there is somebody to set setpoints and acknowledge faults."""
        return self.has_keys or self.is_commanded

    @property
    def heat_command(self) -> str:
        """The host's command to heat it, such as `M104 T0`; raises LookupError when none does."""
        gcode = gcode_of(self.controller)
        for address, loop in gcode.loops.items() if gcode else ():
            if loop == self.loop_name:
                return heats(address)
        raise LookupError(f"No host commands {self.loop_name}.")

    @property
    def key_step_k(self) -> float:
        """By how much UP and DOWN move the loop's setpoint, K; 0 where they do not."""
        keypad = keypad_of(self.controller)
        return keypad.step_k if keypad is not None and keypad.loop == self.loop_name else 0.0


@dataclass(frozen=True)
class Site(Place):
    """Where faults are tried: the binary is there, too."""

    program: Elf


class State(Protocol):
    """What the program's variables say."""

    @property
    def fault(self) -> int:
        """The latched fault, 0 for none."""

    def loop(self, member: str) -> float:
        """Return a number of the loop's state."""


@dataclass(frozen=True)
class OfState:
    """A condition of nothing but variables: while those that it has read stay, so does it."""

    met: Callable[[State], bool]

    def __call__(self, state: State) -> bool:
        """Tell whether it is so now."""
        return self.met(state)


class Operated(Protocol):
    """A controller on its machine, with somebody who asks for setpoints."""

    step_s: float

    @property
    def site(self) -> Place:
        """The controller, and the loop in question."""

    def set_setpoint(self, setpoint_c: float) -> None:
        """Ask for a setpoint, °C, and switch on."""

    def switch_off(self) -> None:
        """Switch the loop off, by its switch or its setpoint."""

    def run(self, seconds: float) -> None:
        """Go on for a time."""

    def until(self, condition: OfState, within_s: float) -> bool:
        """Go on until something is so; False if it takes longer."""
