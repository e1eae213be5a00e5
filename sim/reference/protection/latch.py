"""The controller's one fault latch: the first fault of any loop stops all of them.

After repeated trips it is locked out (docs/control.md, "Lock-out").
"""

from collections.abc import Mapping

from heatwright.sim.reference.loop import EMERGENCY_STOP
from heatwright.sim.reference.modelled_loop import ModelledLoop
from heatwright.sim.reference.numbers import SECOND_US, TICK_US, ZERO
from heatwright.spec import RULES, Controller
from heatwright.spec.rules import NO_LOCKOUT

UNCOUNTED = tuple(code for code, rule in RULES.items() if rule.id in NO_LOCKOUT)


class Lockout:
    """Counts trips, and decides whether only a person at the machine can acknowledge.

    A loss of power is not modelled: without a keypad nothing ends a lock-out.
    """

    def __init__(self, controller: Controller) -> None:
        """Start without a trip."""
        self._spec = controller.lockout
        self._tripped_s = 0
        self.trips = 0

    @property
    def hold_us(self) -> tuple[int, int]:
        """Shortest and longest time for which a person must hold SELECT, µs."""
        if self._spec is None:
            return 1, 0  # never
        hold_us = round(self._spec.hold_s * SECOND_US)
        return hold_us, 2 * hold_us

    @property
    def is_locked(self) -> bool:
        """Whether hosts, masters, touches and a short press can no longer acknowledge."""
        return self._spec is not None and self.trips == self._spec.trips

    def counts(self, code: int) -> bool:
        """Return whether a trip of a rule counts; code 0 is no trip."""
        counts = self._spec is not None and code > 0
        for other in UNCOUNTED:
            counts = counts and code != other
        return counts

    def age(self, now_us: int) -> None:
        """Forget trips that are too old, after the steps of the tick."""
        since_s = now_us // SECOND_US - self._tripped_s
        if self._spec is not None and not self.is_locked and since_s >= int(self._spec.within_s):
            self.trips = 0

    def take(self, trips: int, at_us: int) -> None:
        """Take over a reported count of earlier trips, and the time of the last one.

        An equal count means a new trip, if the earlier trips would have been forgotten by then.
        """
        at_s = at_us // SECOND_US
        within_s = self._spec.within_s if self._spec else 0.0
        if trips != self.trips or at_s - self._tripped_s >= within_s:
            self._tripped_s = at_s
            self.trips = trips

    def count(self, code: int, now_us: int) -> None:
        """Count a trip; first forget trips that were too old in the tick before."""
        if self.counts(code):
            self.age(now_us - TICK_US)
            self._tripped_s = now_us // SECOND_US
            self.trips += 1


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
