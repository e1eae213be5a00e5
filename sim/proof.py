"""The signal which shows that a fan turns: an airflow contact, or pulses of a tachometer."""

from heatwright.sim.avr import Avr
from heatwright.sim.native.fan import Fan
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.spec import Controller, DigitalOutput, Proof, facts_of

STARTS_S = 0.5
STOPS_S = 1.0
"""Time until the air flows, and until it stops: for a 24 V fan and an airflow switch with a
vane."""
LAG_S = 0.5
"""Time constant of a fan's speed."""


class AirflowSwitch:
    """An airflow contact, closed to ground while a fan turns.

    It is simulated as a relay's mirror contact whose coil has current while the fan is off. stands
    -- whether the fan does not turn, whatever its line's level; wire -- the state of the contact's
    wire; both faults survive a loss of power.
    """

    def __init__(self, fan: str) -> None:
        """Create the sound proof of a fan, not yet wired."""
        self.fan = fan
        self.stands = False
        self.wire = Wire.SOUND
        self._relay: Relay | None = None

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Connect to a processor that has just been powered on."""
        output, proof = _parts(controller, self.fan)
        pins = controller.board.pins
        self._relay = Relay(
            avr,
            pins[output.pin].port_name,
            pins[proof.pin].port_name,
            active_high=output.active == "low",
            operate_s=STOPS_S,
            release_s=STARTS_S,
        )
        self.fail(stands=self.stands, wire=self.wire)

    def fail(self, *, stands: bool = False, wire: Wire = Wire.SOUND) -> None:
        """Set the faults of fan and wire, or repair them."""
        self.stands, self.wire = stands, wire
        assert self._relay is not None  # noqa: S101 - the device wires it at power-on
        self._relay.fail(Armature.WELDED if stands else Armature.SOUND, wire)


class FanTachometer:
    """A tachometer: an open collector that pulses to ground, usually twice per revolution.

    Its faults survive a loss of power.
    """

    def __init__(self, fan: str) -> None:
        """Create the sound proof of a fan, not yet wired."""
        self.fan = fan
        self._how = 1.0, 0.0, 0.5, Wire.SOUND
        self._motor: Fan | None = None

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Connect to a processor that has just been powered on; the fan stands still."""
        output, proof = _parts(controller, self.fan)
        assert proof.tachometer is not None  # noqa: S101 - else it is an AirflowSwitch
        pins = controller.board.pins
        self._motor = Fan(
            avr,
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
        """Set the faults of fan and wire, or repair them; a fan that stands still has a pace of 0.

        pace -- share of its normal speed; noise_hz -- pulses per second on the line instead of its
        own; low_share -- share of each pulse in which the line is low.
        """
        self._how = 0.0 if stands else pace, noise_hz, low_share, wire
        self._break()

    def _break(self) -> None:
        assert self._motor is not None  # noqa: S101 - the device wires it at power-on
        self._motor.fail(*self._how)


def proofs_of(controller: Controller) -> dict[str, AirflowSwitch | FanTachometer]:
    """Create the airflow switches and tachometers, by fan; not yet wired."""
    return {
        fan: FanTachometer(fan) if proof.tachometer else AirflowSwitch(fan)
        for fan, proof in facts_of(controller).proofs.items()
    }


def _parts(controller: Controller, fan: str) -> tuple[DigitalOutput, Proof]:
    output = controller.on_off_output(fan)
    assert output.proof is not None  # noqa: S101 - there is one where the fan has one
    return output, output.proof
