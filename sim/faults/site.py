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
    gcode_of,
    modbus_of,
)
from heatwright.spec.commands import keypad_of
from heatwright.spec.facts import LoopFacts, facts_of


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
    def facts(self) -> LoopFacts:
        """What is known of it: who commands it, and how."""
        return facts_of(self.controller, self.loop_name)

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
        return self.facts.keyed and self.facts.programmed

    @property
    def has_keys_alone(self) -> bool:
        """Whether UP and DOWN are all that sets the setpoint, step by step."""
        others = modbus_of(self.controller) or self.facts.touched
        return self.facts.switched and not others

    @property
    def has_operator(self) -> bool:
        """Whether there is somebody to set setpoints and acknowledge faults."""
        return self.has_keys or self.facts.commanded

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
        """Return whether the condition holds now."""
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
        """Run for a time."""

    def until(self, condition: OfState, within_s: float) -> bool:
        """Run until a condition holds; return False if that takes longer."""
