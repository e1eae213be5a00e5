"""What proves that a fan turns: a contact in its air, or the pulses of its tachometer."""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.native.fan import Fan
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.spec import Controller, DigitalOutput, Proof, proofs

STARTS_S = 0.5
STOPS_S = 1.0
"""Until the air flows, and until it no longer does: a fan for a supply of 24 V, an airflow switch
with a vane."""
LAG_S = 0.5
"""Time constant of a fan's speed: its rotor against its magnets and the air."""


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
        output, proof = _parts(controller, self.fan)
        pins = controller.board.pins
        self._relay = avr.relay(
            pins[output.pin].port_name,
            pins[proof.pin].port_name,
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


class FanTachometer:
    """The open collector of a fan, to ground: twice in a revolution, mostly.

    What is broken outlives a loss of power.
    """

    def __init__(self, fan: str) -> None:
        """Make a sound one of a fan, not yet wired."""
        self.fan = fan
        self._how = 1.0, 0.0, 0.5, Wire.SOUND
        self._motor: Fan | None = None

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Wire it to a processor that has just been powered on; it stands still."""
        output, proof = _parts(controller, self.fan)
        assert proof.tachometer is not None  # noqa: S101 - else it is an AirflowSwitch
        pins = controller.board.pins
        self._motor = avr.fan(
            pins[output.pin].port_name,
            pins[proof.pin].port_name,
            active_high=output.active == "high",
            full_hz=proof.tachometer.pulses_hz(proof.tachometer.speed_rpm),
            lag_s=LAG_S,
        )
        self._break()

    def fail(
        self,
        *,
        stands: bool = False,
        wire: Wire = Wire.SOUND,
        pace: float = 1.0,
        noise_hz: float = 0.0,
        low_share: float = 0.5,
    ) -> None:
        """Break fan or wire so, or mend them; a fan that stands has a pace of 0.

        pace -- its speed, as a share of its own; noise_hz -- pulses that are on the line instead;
        low_share -- of each pulse.
        """
        self._how = 0.0 if stands else pace, noise_hz, low_share, wire
        self._break()

    def _break(self) -> None:
        assert self._motor is not None  # noqa: S101 - it is wired before anybody breaks it
        self._motor.fail(*self._how)


def proofs_of(controller: Controller) -> dict[str, AirflowSwitch | FanTachometer]:
    """Make the airflow switches and tachometers, by fan; they are not yet wired."""
    return {
        fan: FanTachometer(fan) if proof.tachometer else AirflowSwitch(fan)
        for fan, proof in proofs(controller).items()
    }


def _parts(controller: Controller, fan: str) -> tuple[DigitalOutput, Proof]:
    output = controller.on_off_output(fan)
    assert output.proof is not None  # noqa: S101 - there is one where the fan has one
    return output, output.proof
