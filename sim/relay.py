"""The safety relay in series with every heater."""

from __future__ import annotations

from typing import Any

from heatwright.sim.avr import Avr
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.spec import Controller

OPERATE_S = 0.015
RELEASE_S = 0.015
"""Longest times of a 30 A power relay, its bouncing included (TE T9A, data sheet)."""


class SafetyRelay:
    """Its coil at an output, its main contacts in the heaters' supply, its mirror contact at a pin.

    armature, wire -- what is broken; it outlives a loss of power.
    """

    def __init__(self) -> None:
        """Make a sound one, not yet wired."""
        self.armature = Armature.SOUND
        self.wire = Wire.SOUND
        self._relay: Relay | None = None
        self._avr: Avr | None = None
        self._cycle = self._closed = 0

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Wire it to a processor that has just been powered on."""
        name = controller.safety.relay
        assert name is not None  # noqa: S101 - there is one only where the specification names it
        output, feedback = controller.on_off_output(name), controller.safety.relay_feedback
        pins = controller.board.pins
        self._avr = avr
        self._relay = avr.relay(
            pins[output.pin].port_name,
            None if feedback is None else pins[feedback].port_name,
            active_high=output.active == "high",
            operate_s=OPERATE_S,
            release_s=RELEASE_S,
        )
        self._relay.fail(self.armature, self.wire)
        self._cycle, self._closed = avr.cycle, self._relay.closed_cycles

    def fail(self, armature: Armature = Armature.SOUND, wire: Wire = Wire.SOUND) -> None:
        """Break it so, or mend it."""
        self.armature, self.wire = armature, wire
        self._wired.fail(armature, wire)

    @property
    def closed(self) -> bool:
        """Whether its main contacts conduct now."""
        return self._wired.closed

    @property
    def operations(self) -> int:
        """How often they have moved since the power-up, either way."""
        return self._wired.operations

    def power_off(self) -> None:
        """Let the coil go with the controller's supply, until `power_on`."""
        self._avr = None

    @property
    def pointer(self) -> Any:
        """The relay, for the shim's functions."""
        return self._wired.pointer

    @property
    def closed_cycles(self) -> int:
        """Cycles for which they have conducted since the power-up."""
        return self._wired.closed_cycles

    def closed_fraction(self) -> float:
        """Return the share of time they conducted since the last call, 0..1.

        Without power, or if no time has passed, as they are.
        """
        if self._avr is None:
            return float(self.armature is Armature.WELDED)
        cycle, closed = self._avr.cycle, self._wired.closed_cycles
        elapsed, on = cycle - self._cycle, closed - self._closed
        self._cycle, self._closed = cycle, closed
        return on / elapsed if elapsed else float(self.closed)

    @property
    def _wired(self) -> Relay:
        assert self._relay is not None  # noqa: S101 - it is wired before anybody asks
        return self._relay
