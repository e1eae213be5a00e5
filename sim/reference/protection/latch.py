"""The controller's one fault latch: the first fault of any loop stops all of them."""

from collections.abc import Mapping

from heatwright.sim.reference.loop import EMERGENCY_STOP
from heatwright.sim.reference.modelled_loop import ModelledLoop
from heatwright.sim.reference.numbers import ZERO
from heatwright.sim.reference.protection.lockout import Lockout
from heatwright.spec import Controller


class Latch:
    """Keeps the fault equal in the models of all loops."""

    def __init__(self, controller: Controller, loops: Mapping[str, ModelledLoop]) -> None:
        """Start without a fault."""
        self._loops = tuple(loops.values())
        self._is_latched = False
        self.lockout = Lockout(controller)
        self.now_us = 0
        """Time since power-up, µs."""

    @property
    def code(self) -> int:
        """The fault; 0 if there is none."""
        return self._loops[0].reference.fault_code

    def take(self, loop: ModelledLoop) -> None:
        """Pass a fault that one loop has found in its step to all loops."""
        found = loop.reference
        if found.fault_code and not self._is_latched:
            self._is_latched = True
            self.lockout.count(found.fault_code, self.now_us)
        self.lockout.age(self.now_us)
        if found.fault_code:
            for other in self._loops:
                other.take_fault(found.fault_code, found.fault_temperature_c, loop.step_s)

    def stop(self) -> None:
        """Latch the operator's stop, unless a fault is already latched."""
        self._is_latched = True
        for loop in self._loops:
            loop.take_fault(EMERGENCY_STOP, ZERO)

    def release(self) -> None:
        """End a lock-out, as a person at the machine."""
        if self.lockout.is_locked:
            self.lockout.trips = 0
            self.acknowledge()

    def acknowledge(self) -> None:
        """Acknowledge the fault, if there is one that is not locked out."""
        if self.lockout.is_locked:
            return
        self._is_latched = False
        for loop in self._loops:
            loop.operator.acknowledge()
