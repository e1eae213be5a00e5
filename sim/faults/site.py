"""What a fault is tried on: a controller with its machine and its binary, and one of its loops."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from heatwright.sim.binary.elf import Elf
from heatwright.sim.interfaces.gcode import heats
from heatwright.spec import Controller, Loop, LoopFacts, ThermalNetwork, facts_of


@dataclass(frozen=True)
class Place:
    """A controller on its machine, and the loop under test."""

    controller: Controller
    loop_name: str

    @property
    def loop(self) -> Loop:
        """The loop under test."""
        return self.controller.loops[self.loop_name]

    @property
    def facts(self) -> LoopFacts:
        """The loop's facts: who commands it, and how."""
        return facts_of(self.controller, self.loop_name)

    @property
    def network(self) -> ThermalNetwork:
        """The plant of the spec. Raises ValueError: there is none."""
        return self.controller.simulated.plant

    @property
    def ambient_c(self) -> float:
        """The ambient temperature of the spec, °C."""
        simulation = self.controller.simulation
        return simulation.ambient_c if simulation else 20.0

    @property
    def has_keys(self) -> bool:
        """Whether the controller has the keys UP, DOWN and SELECT."""
        return facts_of(self.controller).keypad is not None

    @property
    def has_menu(self) -> bool:
        """Whether the keys operate a menu, as on a loop with programs."""
        return self.facts.keyed and self.facts.programmed

    @property
    def has_keys_alone(self) -> bool:
        """Whether the setpoint of a switched loop can be set with UP and DOWN only."""
        others = facts_of(self.controller).modbus or self.facts.touched
        return self.facts.switched and not others

    @property
    def is_set(self) -> bool:
        """Whether somebody can set the loop's setpoint."""
        return self.facts.commanded or self.key_step_k > 0

    @property
    def heat_command(self) -> str:
        """The host's command to heat the loop, such as `M104 T0`. Raises LookupError: no host."""
        gcode = facts_of(self.controller).gcode
        for address, loop in gcode.loops.items() if gcode else ():
            if loop == self.loop_name:
                return heats(address)
        raise LookupError(f"No G-code host commands loop {self.loop_name}.")

    @property
    def key_step_k(self) -> float:
        """The step by which UP and DOWN change the loop's setpoint, K; 0 if they do not."""
        keypad = facts_of(self.controller).keypad
        return keypad.step_k if keypad is not None and keypad.loop == self.loop_name else 0.0


@dataclass(frozen=True)
class Site(Place):
    """A place and its binary, on which a fault is tried."""

    program: Elf


class State(Protocol):
    """The variables of the running program."""

    @property
    def fault(self) -> int:
        """The latched fault, 0 for none."""

    def loop(self, member: str) -> float:
        """Return a member of the loop's state."""


@dataclass(frozen=True)
class OfState:
    """A condition on variables only: it changes only if one of the variables changes."""

    met: Callable[[State], bool]

    def __call__(self, state: State) -> bool:
        """Return whether the condition holds now."""
        return self.met(state)


LATCHED = OfState(lambda now: now.fault != 0)
"""A fault is latched."""


class Operated(Protocol):
    """A controller on its machine, with somebody who sets its setpoints."""

    step_s: float

    @property
    def site(self) -> Place:
        """The controller, and the loop that is operated."""

    def set_setpoint(self, setpoint_c: float) -> None:
        """Set a setpoint, °C, and switch the loop on."""

    def switch_off(self) -> None:
        """Switch the loop off, by its switch or with a setpoint of 0."""

    def run(self, seconds: float) -> None:
        """Run for a time."""

    def until(self, condition: OfState, within_s: float) -> bool:
        """Run until a condition holds; return False if that takes longer."""
