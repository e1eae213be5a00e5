"""Outputs: pins that switch heaters and fans, or drive a stepper."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from heatwright.spec.base import Least, Model, PinName, WholeNumber
from heatwright.spec.quantity import Quantity
from heatwright.spec.registry import with_brought
from heatwright.spec.sensing.conversion import TICK_S
from heatwright.spec.sensing.currents import Current
from heatwright.spec.units import (
    ACCELERATION,
    DURATION,
    FREQUENCY,
    LENGTH,
    POWER,
    SPEED,
    SPIN,
    VOLTAGE,
)

SLOWEST_PWM_HZ = 1.0
"""Minimum frequency; slower switching needs a time-proportional output."""

WINDOW_PULSES = 16
"""Pulses of a tachometer in one counting window, at the slowest speed that is allowed."""

Active = Literal["high", "low"]
Power = Annotated[float, Quantity(POWER, least=0.001)]
Volt = Annotated[float, Quantity(VOLTAGE, least=0.1)]
_Rest = Annotated[float, Quantity(DURATION, least=0.0, most=3600.0)]
_SUPPLY = "Voltage that supplies the load."
_CURRENT = "Its measured current, with limit and trip; needs power and supply."
_PIN = "Pin that drives the switch."
_ACTIVE = "Level at which the switch conducts; the other level is off."
_POWER = "Power of the load when fully on; the simulation and the checks need it for a heater."


class Tachometer(Model):
    """Pulses that a fan makes as it turns, counted to a speed."""

    speed_rpm: Annotated[float, Quantity(SPIN, least=60.0)] = Field(
        alias="speed", description="Nominal speed, from its data sheet."
    )
    pulses: Annotated[int, WholeNumber("a number of pulses", 1, 12, 2)] = Field(
        2, description="Pulses per revolution."
    )
    minimum_rpm: Annotated[float, Quantity(SPIN, least=1.0)] | None = Field(
        None, alias="minimum", description="A slower fan has stopped. Default: half of `speed`."
    )
    maximum_rpm: Annotated[float, Quantity(SPIN, least=1.0)] | None = Field(
        None, alias="maximum", description="More pulses are noise. Default: 1.5 times `speed`."
    )

    @property
    def slowest_rpm(self) -> float:
        """Slowest speed at which the fan is not reported as stopped, rpm."""
        return self.speed_rpm / 2 if self.minimum_rpm is None else self.minimum_rpm

    @property
    def fastest_rpm(self) -> float:
        """Fastest speed at which the pulses are not taken for noise, rpm."""
        return self.speed_rpm * 1.5 if self.maximum_rpm is None else self.maximum_rpm

    def pulses_hz(self, speed_rpm: float) -> float:
        """Return the pulses in a second at a speed."""
        return speed_rpm * self.pulses / 60

    @property
    def window_ticks(self) -> int:
        """Ticks over which pulses are counted: `WINDOW_PULSES` of the slowest speed."""
        slowest_hz = self.pulses_hz(self.slowest_rpm)
        return math.ceil(WINDOW_PULSES / slowest_hz / TICK_S - 1e-9)

    @property
    def window_s(self) -> float:
        """Time over which pulses are counted, s."""
        return self.window_ticks * TICK_S


class Proof(Model):
    """The signal which shows that a fan turns: of a contact in its air, or of its tachometer."""

    pin: PinName = Field(
        description="Pin at a contact that the stream of air closes to ground, or at the "
        "tachometer's wire."
    )
    within_s: Annotated[float, Quantity(DURATION, least=0.1, most=60.0)] = Field(
        5.0,
        alias="within",
        description="Rule `fan_stopped`: time that the fan may take to start, or that its signal "
        "may be missing.",
    )
    tachometer: Tachometer | None = Field(
        None, description="A tachometer's pulses are at the pin, instead of a contact."
    )


class DigitalOutput(Model):
    """Switched on and off: a relay, or a fan."""

    is_on_off: ClassVar[Literal[True]] = True
    is_windowed: ClassVar[bool] = False
    cycle_s: ClassVar[float] = 0.0
    feeds: ClassVar[Literal[False]] = False
    frequency_hz: ClassVar[float] = 0.0
    shortest_pulse_s: ClassVar[float] = 0.0
    shortest_level_s: ClassVar[float] = 0.0
    rated_v: ClassVar[None] = None
    full_share: ClassVar[float] = 1.0
    mean_of_rms: ClassVar[float] = 1.0

    kind: Literal["digital"]
    pin: PinName = Field(description=_PIN)
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    runs: Literal["always", "with_loop"] = Field(
        "with_loop",
        description="`always`: on as long as the controller runs; a loop's fan needs this.",
    )
    minimum_on_s: _Rest = Field(
        0.0,
        alias="minimum_on",
        description="Shortest time on; a heater's protections do not wait for it.",
    )
    minimum_off_s: _Rest = Field(
        0.0, alias="minimum_off", description="Shortest time off; also after the power-up."
    )
    supply_v: Volt | None = Field(None, alias="supply", description=_SUPPLY)
    current: Current | None = Field(None, description=_CURRENT)
    proof: Proof | None = Field(
        None, description="Signal that a loop's fan turns. Default: none; on means that it turns."
    )
    least: ClassVar[Least] = Least(10, 0)

    @property
    def always_runs(self) -> bool:
        """Whether the output is on as long as the controller runs."""
        return self.runs == "always"

    @property
    def stays_on_s(self) -> float:
        """Shortest time on, s."""
        return self.minimum_on_s

    @property
    def stays_off_s(self) -> float:
        """Shortest time off, s."""
        return self.minimum_off_s

    def pulse_s(self, share: float) -> float:
        """Return the length of a pulse at a share of the time, s: 0, as it has no pulses."""
        return share * self.cycle_s


class PwmOutput(Model):
    """Pulse width by a timer of the chip; tens of Hz to tens of kHz."""

    is_on_off: ClassVar[Literal[False]] = False
    always_runs: ClassVar[bool] = False
    stays_on_s: ClassVar[float] = 0.0
    stays_off_s: ClassVar[float] = 0.0
    proof: ClassVar[None] = None
    is_windowed: ClassVar[bool] = False
    feeds: ClassVar[Literal[False]] = False
    shortest_pulse_s: ClassVar[float] = 0.0
    shortest_level_s: ClassVar[float] = 0.0

    kind: Literal["pwm"]
    pin: PinName = Field(description=_PIN)
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    frequency_hz: Annotated[float, Quantity(FREQUENCY, least=SLOWEST_PWM_HZ)] = Field(
        alias="frequency",
        description="PWM frequency, within 0.5 %; above 500 Hz only at a timer's pin.",
    )
    supply_v: Volt | None = Field(None, alias="supply", description=_SUPPLY)
    rated_v: Volt | None = Field(
        None, alias="rated", description="Voltage of the load at its power. Default: the supply's."
    )
    current: Current | None = Field(None, description=_CURRENT)
    least: ClassVar[Least] = Least(90, 1)

    @property
    def cycle_s(self) -> float:
        """Time from one pulse to the next, s."""
        return 1 / self.frequency_hz

    def pulse_s(self, share: float) -> float:
        """Return the length of a pulse at a share of the time, s."""
        return share * self.cycle_s

    @property
    def full_share(self) -> float:
        """Duty, as a share, at which the supply gives the rated power: (rated/supply)²."""
        return self.mean_of_rms**2

    @property
    def mean_of_rms(self) -> float:
        """Mean current at full duty, for each ampere of its root mean square: rated/supply."""
        if self.supply_v is None or self.rated_v is None:
            return 1.0
        return self.rated_v / self.supply_v


class TimeProportionalOutput(Model):
    """On for a part of each window, switched by the tick: for relays and slow loads; no whine."""

    is_on_off: ClassVar[Literal[False]] = False
    always_runs: ClassVar[bool] = False
    stays_on_s: ClassVar[float] = 0.0
    stays_off_s: ClassVar[float] = 0.0
    proof: ClassVar[None] = None
    is_windowed: ClassVar[bool] = True
    feeds: ClassVar[Literal[False]] = False
    frequency_hz: ClassVar[float] = 0.0
    full_share: ClassVar[float] = 1.0
    mean_of_rms: ClassVar[float] = 1.0
    supply_v: ClassVar[None] = None
    rated_v: ClassVar[None] = None
    current: ClassVar[None] = None

    kind: Literal["time_proportional"]
    pin: PinName = Field(description=_PIN)
    active: Active = Field("high", description=_ACTIVE)
    power_w: Power | None = Field(None, alias="power", description=_POWER)
    window_s: Annotated[float, Quantity(DURATION, least=0.01)] = Field(
        alias="window", description="Length of one switching cycle."
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
    distribution: Literal["burst", "spread"] = Field(
        "burst", description="On-time in one piece, or spread over the window in single steps."
    )
    least: ClassVar[Least] = Least(140, 5)

    @property
    def cycle_s(self) -> float:
        """Time from the beginning of one window to that of the next, s."""
        return self.window_s

    @property
    def shortest_pulse_s(self) -> float:
        """Shortest pulse that is made, s; a shorter one is omitted."""
        return self.minimum_on_s

    @property
    def shortest_level_s(self) -> float:
        """Shortest time at one level, s: of a pulse, or of a pause."""
        if self.distribution == "spread":
            return self.resolution_s
        return max(self.resolution_s, min(self.minimum_on_s, self.minimum_off_s))

    def pulse_s(self, share: float) -> float:
        """Return the length of a pulse at a share of the time, s: one step if pulses are spread."""
        return self.resolution_s if self.distribution == "spread" else share * self.cycle_s


class Stepper(Model):
    """A stepper motor that feeds material, behind a driver with step, direction and enable."""

    is_on_off: ClassVar[Literal[False]] = False
    always_runs: ClassVar[bool] = False
    stays_on_s: ClassVar[float] = 0.0
    stays_off_s: ClassVar[float] = 0.0
    proof: ClassVar[None] = None
    is_windowed: ClassVar[bool] = False
    feeds: ClassVar[Literal[True]] = True
    full_share: ClassVar[float] = 1.0
    power_w: ClassVar[None] = None
    frequency_hz: ClassVar[float] = 0.0
    supply_v: ClassVar[None] = None
    rated_v: ClassVar[None] = None
    current: ClassVar[None] = None

    kind: Literal["stepper"]
    step: PinName = Field(description="Pin at the driver's STEP; a rising edge is a step.")
    direction: PinName = Field(description="Pin at the driver's DIR; high is forwards.")
    enable: PinName = Field(description="Pin at the driver's ENABLE.")
    enable_active: Active = Field("low", description="Level at which the motor is held.")
    steps: Annotated[int, WholeNumber("a number of steps", 1, 10_000, 200)] = Field(
        description="Full steps per revolution."
    )
    microsteps: Annotated[int, WholeNumber("a number of microsteps", 1, 256, 16)] = Field(
        1, description="Microsteps of a full step, as set at the driver."
    )
    lead_mm: Annotated[float, Quantity(LENGTH, least=0.001)] = Field(
        alias="lead", description="Feed per revolution."
    )
    maximum_mm_per_s: Annotated[float, Quantity(SPEED, least=0.001)] = Field(
        alias="maximum", description="Highest speed."
    )
    acceleration_mm_per_s2: Annotated[float, Quantity(ACCELERATION, least=0.001)] = Field(
        alias="acceleration", description="Acceleration of the feed."
    )
    least: ClassVar[Least] = Least(1400, 22)

    @property
    def steps_per_mm(self) -> float:
        """Microsteps for a millimetre of feed."""
        return self.steps * self.microsteps / self.lead_mm


Switch = DigitalOutput | PwmOutput | TimeProportionalOutput
"""Outputs that drive a load at one pin."""

Output = Annotated[
    DigitalOutput | PwmOutput | Stepper | TimeProportionalOutput, Field(discriminator="kind")
]
if not TYPE_CHECKING:  # mypy knows only heatwright's own kinds
    Output = with_brought("output", Output)


def is_held(output: Output) -> bool:
    """Return whether an output has minimum times."""
    return output.stays_on_s > 0 or output.stays_off_s > 0


def always_running(outputs: Mapping[str, Output]) -> list[str]:
    """Name the outputs that run as long as there is power."""
    return [name for name, output in outputs.items() if output.always_runs]


def full_a(output: Switch) -> float | None:
    """Return the current of a load that is on, A; None if power or supply are not known.

    A resistor that has its power at its rated voltage draws the current supply · power / rated².
    """
    supply_v = output.supply_v
    if supply_v is None or output.power_w is None:
        return None
    rated_v = output.rated_v or supply_v
    return float(supply_v * output.power_w / rated_v**2)


def full_rms_a(output: Switch) -> float | None:
    """Return the root mean square of a load's current at full duty, A; None like `full_a`."""
    peak_a = full_a(output)
    return None if peak_a is None else peak_a * output.mean_of_rms


def waits_s(output: Switch) -> float:
    """Return how long it may take until an output that is off follows a higher duty, s.

    A new duty waits for the next window. Meanwhile one missing reading may make the duty 0 again,
    just before that window, so that the output has to wait for one more.
    """
    return max(output.stays_off_s, (2 if output.is_windowed else 1) * output.cycle_s)


def limit_w(output: Switch) -> float:
    """Return the power that the limit of a load's current allows, W; infinite without a limit."""
    current, rms_a = output.current, full_rms_a(output)
    if current is None or current.limit_a is None or rms_a is None:
        return math.inf
    return float((output.power_w or 0.0) * (current.limit_a / rms_a) ** 2)
