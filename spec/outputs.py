"""Outputs: what switches heaters and fans."""

from typing import Annotated, Literal

from pydantic import Field

from heatwright.spec.base import Model, PinName
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import DURATION, FREQUENCY, POWER

SLOWEST_PWM_HZ = 1.0
"""Slower is the business of a time-proportional output."""

Active = Literal["high", "low"]
Power = Annotated[float, Quantity(POWER, least=0.001)]
_PIN = "Pin that drives the switch."
_ACTIVE = "Level at which the switch conducts; the other level is off."
_POWER = "Power of the load when fully on; the simulation and the checks need it for a heater."


class DigitalOutput(Model):
    """Switched on and off: a relay, or a fan."""

    kind: Literal["digital"]
    pin: PinName = Field(description=_PIN)
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    runs: Literal["always", "with_loop"] = Field(
        "with_loop",
        description="`always`: on as long as the controller runs. A fan a loop names needs it.",
    )


class PwmOutput(Model):
    """Pulse width by a timer of the chip; tens of Hz to tens of kHz."""

    kind: Literal["pwm"]
    pin: PinName = Field(description="A pin with a timer's compare output.")
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    frequency_hz: Annotated[float, Quantity(FREQUENCY, least=SLOWEST_PWM_HZ)] = Field(
        alias="frequency",
        description="Held within 0.5 %; a timer offers only some. Most coils whine in between.",
    )


class TimeProportionalOutput(Model):
    """On for a part of each window, switched by the tick: for relays and slow loads; no whine."""

    kind: Literal["time_proportional"]
    pin: PinName = Field(description=_PIN)
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    window_s: Annotated[float, Quantity(DURATION, least=0.01)] = Field(
        alias="window", description="Time over which the power is measured out."
    )
    resolution_s: Annotated[float, Quantity(DURATION, least=0.01)] = Field(
        0.01,
        alias="resolution",
        description="Smallest part of the window; a multiple of the 10 ms tick.",
    )
    minimum_on_s: Annotated[float, Quantity(DURATION, least=0.0)] = Field(
        0.0, alias="minimum_on", description="A shorter pulse is left out."
    )
    minimum_off_s: Annotated[float, Quantity(DURATION, least=0.0)] = Field(
        0.0, alias="minimum_off", description="A shorter pause is left out."
    )


Output = Annotated[DigitalOutput | PwmOutput | TimeProportionalOutput, Field(discriminator="kind")]
