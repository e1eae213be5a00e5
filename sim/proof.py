"""A contact in the air of a fan."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.spec import Controller, DigitalOutput

STARTS_S = 0.5
STOPS_S = 1.0
"""Until the air flows, and until it no longer does: a fan for a supply of 24 V, an airflow switch
with a vane."""


class AirflowSwitch:
    """Closed to ground while a fan turns.

    Seen from its pin it is a relay's mirror contact, whose coil has current while the fan is off.
    stands -- whether the fan stands still, whatever its line says; wire -- the contact's; both
    outlive a loss of power.
    """

    def __init__(self, fan: str) -> None:
        """Make a sound one of a fan, not yet wired."""
        self.fan = fan
        self.stands = False
        self.wire = Wire.SOUND
        self._relay: Relay | None = None

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Wire it to a processor that has just been powered on."""
        output = controller.outputs[self.fan]
        assert isinstance(output, DigitalOutput)  # noqa: S101 - the language allows no other
        assert output.proof is not None  # noqa: S101 - there is one where the fan has one
        pins = controller.board.pins
        self._relay = avr.relay(
            pins[output.pin].port_name,
            pins[output.proof.pin].port_name,
            active_high=output.active == "low",
            operate_s=STOPS_S,
            release_s=STARTS_S,
        )
        self.fail(stands=self.stands, wire=self.wire)

    def fail(self, *, stands: bool = False, wire: Wire = Wire.SOUND) -> None:
        """Break fan or wire so, or mend them."""
        self.stands, self.wire = stands, wire
        assert self._relay is not None  # noqa: S101 - it is wired before anybody breaks it
        self._relay.fail(Armature.WELDED if stands else Armature.SOUND, wire)
