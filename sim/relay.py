"""The safety relay in series with every heater."""

from heatwright.sim.avr import Avr
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.spec import Controller

OPERATE_S = 0.015
RELEASE_S = 0.015
"""Longest times of a 30 A power relay, bouncing included (TE T9A data sheet)."""


class SafetyRelay:
    """A relay: coil at an output, main contacts in the heaters' supply, mirror contact at a pin.

    armature, wire -- its faults, which survive a loss of power.
    """

    def __init__(self) -> None:
        """Create a sound relay, not yet wired."""
        self.armature = Armature.SOUND
        self.wire = Wire.SOUND
        self._relay: Relay | None = None
        self._avr: Avr | None = None
        self._cycle = self._closed = 0

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Connect to a processor that has just been powered on."""
        name = controller.safety.relay
        assert name is not None  # noqa: S101 - there is one only where the specification names it
        output, feedback = controller.on_off_output(name), controller.safety.relay_feedback
        pins = controller.board.pins
        self._avr = avr
        self._relay = Relay(
            avr,
            pins[output.pin].port_name,
            None if feedback is None else pins[feedback].port_name,
            active_high=output.active == "high",
            operate_s=OPERATE_S,
            release_s=RELEASE_S,
        )
        self._relay.fail(self.armature, self.wire)
        self._cycle, self._closed = avr.cycle, self._relay.closed_cycles

    def fail(self, armature: Armature = Armature.SOUND, wire: Wire = Wire.SOUND) -> None:
        """Set the faults of armature and wire, or repair them."""
        self.armature, self.wire = armature, wire
        self.wired.fail(armature, wire)

    @property
    def closed(self) -> bool:
        """Whether the main contacts conduct now."""
        return self.wired.closed

    def power_off(self) -> None:
        """Release the coil, because the controller's supply is off, until `power_on`."""
        self._avr = None

    def closed_fraction(self) -> float:
        """Return the share of time (0..1) in which the main contacts conducted since the last call.

        Without power, or if no time has passed, it is their present state: 0 or 1.
        """
        if self._avr is None:
            return float(self.armature is Armature.WELDED)
        cycle, closed = self._avr.cycle, self.wired.closed_cycles
        elapsed, on = cycle - self._cycle, closed - self._closed
        self._cycle, self._closed = cycle, closed
        return on / elapsed if elapsed else float(self.closed)

    @property
    def wired(self) -> Relay:
        """The relay at the processor that was powered on last."""
        assert self._relay is not None  # noqa: S101 - the device wires it at power-on
        return self._relay
