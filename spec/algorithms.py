"""Algorithms: how the heater's duty follows from the error of the temperature.

Other code uses these properties of a model, and never tests its kind:
continuous -- its duty may be anything between 0 % and 100 %; has_integral -- it removes a steady
error; tunable -- commands set its gains, and its duty by hand; pid -- the gains themselves;
limits_adjustable -- a host may narrow its limits; cools -- it has a cooler, too. Properties that
end in `_percent` are duties, those in `_k` distances from the setpoint.
"""

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field, StrictBool

from heatwright.spec.base import DEFAULTS, Least, Model
from heatwright.spec.problems import Checked, refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.registry import with_brought
from heatwright.spec.units import DIFFERENCE, DURATION, PERCENT

LEAST_RANGE_PERCENT = 1.0
"""Least distance between the minimum duty and a maximum duty that a command sets: if both were
equal, the duty of an idle loop would be its maximum."""
LARGEST_GAIN = 1e6
"""Maximum gain: far above any useful one; its products with temperatures fit single precision."""


class Gain(Checked):
    """A gain: a bare number, because its unit is fixed."""

    def __init__(self, unit: str) -> None:
        """Set the unit that messages name."""
        super().__init__(self.read_gain, type="number", minimum=0, maximum=LARGEST_GAIN)
        self.unit = unit

    def read_gain(self, value: object) -> float:
        """Accept a number from 0 to `LARGEST_GAIN`."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise refuse("a gain is a bare number", f"Write the number alone; it is in {self.unit}")
        if value < 0:
            raise refuse(
                f"{value} is negative: a hotter reading would add heat", "Use a gain of 0 or more"
            )
        if not value <= LARGEST_GAIN:
            raise refuse(f"{value} is too large", f"Use at most {LARGEST_GAIN:.0f}")
        return float(value)


Percent = Annotated[float, Quantity(PERCENT, least=0.0, most=100.0)]
_Signed = Annotated[float, Quantity(PERCENT, least=-100.0, most=100.0)]
_Filter = Annotated[float, Quantity(DURATION, least=0.0)]
_Lead = Annotated[
    float,
    Quantity(DURATION, least=0.0),
    Field(
        alias="lead",
        description="How far to look ahead: the temperature plus `lead` times its slope decides.",
    ),
]
_LeadFilter = Annotated[
    _Filter, Field(alias="lead_filter", description="Time constant that smooths the slope.")
]


class Lie(NamedTuple):
    """The duty of a loop while its reading is wrong.

    first_percent -- at the beginning; per_s -- its growth, %/s; most_percent -- where it ends.
    """

    first_percent: float
    per_s: float
    most_percent: float

    def reaches_s(self, percent: float) -> float:
        """Return after what time the duty reaches a value, s; infinite if never."""
        if self.first_percent >= percent:
            return 0.0
        if self.per_s <= 0 or self.most_percent < percent:
            return math.inf
        return (percent - self.first_percent) / self.per_s

    def percent(self, time_s: float) -> float:
        """Return the duty at a time after the reading became wrong, %."""
        return min(self.most_percent, self.first_percent + self.per_s * time_s)


class _Switching(Model):
    """The properties of algorithms that have only two duties: full power and none."""

    continuous: ClassVar[bool] = False
    has_integral: ClassVar[bool] = False
    tunable: ClassVar[bool] = False
    pid: ClassVar[None] = None
    full_percent: ClassVar[float] = 100.0
    full_beyond_k: ClassVar[float] = 0.0
    limits_adjustable: ClassVar[bool] = False
    if TYPE_CHECKING:
        lead_s: float

    @property
    def steady_percent(self) -> tuple[float, float]:
        """Lowest and highest duty at a constant reading, %."""
        return 0.0, self.full_percent

    def dose(self, step_k: float, over_s: float) -> tuple[float, float]:
        """Return the duty, %, that a step of the reading causes, and for how long, s."""
        del step_k
        return (self.full_percent if self.lead_s else 0.0), over_s

    def stuck(self, below_k: float, integral_percent: float) -> Lie:
        """Return the duty while the reading is stuck below the setpoint: full power at once."""
        del below_k, integral_percent
        return Lie(self.full_percent, 0.0, self.full_percent)


class OnOff(_Switching):
    """On-off control, with a hysteresis and with a lead (it looks ahead along the slope)."""

    cools: ClassVar[bool] = False
    warm_within_k: ClassVar[None] = None

    kind: Literal["on_off"]
    hysteresis_k: Annotated[float, Quantity(DIFFERENCE, least=0.0)] = Field(
        0.0,
        alias="hysteresis",
        description="Half width: off at setpoint + this, on at setpoint − this.",
    )
    lead_s: _Lead = 0.0
    lead_filter_s: _LeadFilter = 0.0
    least: ClassVar[Least] = Least(940, 37)

    @property
    def off_at_k(self) -> float:
        """Distance above the setpoint at which full power ends, K."""
        return self.hysteresis_k

    @property
    def on_at_k(self) -> float:
        """Distance below the setpoint at which full power begins, K."""
        return self.hysteresis_k

    @property
    def swing_k(self) -> float:
        """Swing of the reading between on and off, K."""
        return 2 * self.hysteresis_k

    @property
    def rests_within_k(self) -> float:
        """Largest steady deviation of a healthy loop above the setpoint, K."""
        return self.hysteresis_k


class ThreePosition(_Switching):
    """Heating below a dead band, cooling above it, neither of them in between."""

    cools: ClassVar[bool] = True

    kind: Literal["three_position"]
    dead_band_k: Annotated[float, Quantity(DIFFERENCE, least=0.001)] = Field(
        alias="dead_band",
        description="Half width: heats below setpoint − this, cools above setpoint + this.",
    )
    hysteresis_k: Annotated[float, Quantity(DIFFERENCE, least=0.0)] = Field(
        0.0,
        alias="hysteresis",
        description="Distance inside the dead band at which heating or cooling ends.",
    )
    lead_s: _Lead = 0.0
    lead_filter_s: _LeadFilter = 0.0
    least: ClassVar[Least] = Least(1270, 41)

    @property
    def off_at_k(self) -> float:
        """Distance above the setpoint at which full power ends, K: 0 or negative."""
        return self.hysteresis_k - self.dead_band_k

    @property
    def on_at_k(self) -> float:
        """Distance below the setpoint at which full power begins, K."""
        return self.dead_band_k

    @property
    def swing_k(self) -> float:
        """Swing of the reading between heating and cooling, K."""
        return 2 * self.dead_band_k

    @property
    def rests_within_k(self) -> float:
        """Largest steady deviation of a healthy loop above the setpoint, K."""
        return self.dead_band_k

    @property
    def warm_within_k(self) -> float:
        """Deviation from the setpoint within which the loop is reported as warm, K."""
        return self.dead_band_k


class IntegralLimits(Model):
    """Bounds of the integral term, and its behaviour while the output is limited."""

    minimum_percent: _Signed = Field(0.0, alias="minimum", description="Lowest contribution.")
    maximum_percent: Percent = Field(100.0, alias="maximum", description="Highest contribution.")
    while_limited: Literal["hold", "run"] = Field(
        "hold",
        description="`hold` stops the integral while it would push a limited output further.",
    )


class OutputLimits(Model):
    """Bounds of the duty."""

    minimum_percent: Percent = Field(0.0, alias="minimum", description="Lowest duty.")
    maximum_percent: Percent = Field(100.0, alias="maximum", description="Highest duty.")


class Pid(Model):
    """Proportional, integral and derivative control; a gain of 0 leaves its term out."""

    continuous: ClassVar[bool] = True
    tunable: ClassVar[bool] = True
    lead_s: ClassVar[float] = 0.0
    cools: ClassVar[bool] = False
    off_at_k: ClassVar[float] = 0.0
    swing_k: ClassVar[float] = 0.0
    warm_within_k: ClassVar[None] = None

    kind: Literal["pid"]
    kp: Annotated[float, Gain("%/K")] = Field(description="Duty per kelvin of error, %/K.")
    ki: Annotated[float, Gain("%/(K·s)")] = Field(
        0.0, description="Duty per kelvin of error and second, %/(K·s)."
    )
    kd: Annotated[float, Gain("%·s/K")] = Field(
        0.0, description="Duty per kelvin per second of slope, %·s/K."
    )
    feed_forward: Annotated[float, Gain("%·s/K")] = Field(
        0.0, description="Duty per kelvin per second of the setpoint's slope in a program, %·s/K."
    )
    derivative_of: Literal["measurement", "error"] = Field(
        "measurement",
        description="With `error` the duty jumps when the setpoint changes, else it does not.",
    )
    derivative_filter_s: _Filter = Field(
        0.0, alias="derivative_filter", description="Time constant that smooths the slope."
    )
    derivative_step: Literal["present", "previous"] = Field(
        "present", description="Step whose slope is used; `previous` is one period late."
    )
    integral: IntegralLimits = Field(
        DEFAULTS, validate_default=True, description="Limits of the integral's contribution."
    )
    output: OutputLimits = Field(DEFAULTS, validate_default=True, description="Limits of the duty.")
    limits_adjustable: StrictBool = Field(
        False,
        description="Let a host narrow the integral's limits and the output's maximum (`M301`); "
        "`M500` keeps them in EEPROM.",
    )
    band_k: Annotated[float, Quantity(DIFFERENCE, least=0.001)] | None = Field(
        None,
        alias="band",
        description="Full power below this band around the setpoint, none above. Default: no band.",
    )
    dead_band_k: Annotated[float, Quantity(DIFFERENCE, least=0.0)] = Field(
        0.0,
        alias="dead_band",
        description="Deviation within which neither proportional nor integral term acts.",
    )
    dead_band_keeps: Literal["integral", "output"] = Field(
        "integral", description="What is kept in the dead band: the integral, or the whole output."
    )
    least: ClassVar[Least] = Least(1290, 52)

    @property
    def pid(self) -> "Pid":
        """The algorithm itself, because it has gains; None for an on-off algorithm."""
        return self

    @property
    def has_integral(self) -> bool:
        """Whether the integral removes a steady error."""
        return self.ki > 0

    @property
    def full_percent(self) -> float:
        """Highest duty of the algorithm, %."""
        return self.output.maximum_percent

    @property
    def on_at_k(self) -> float:
        """Distance below the setpoint that ensures full power, K; without a band infinite."""
        return math.inf if self.band_k is None else self.band_k

    @property
    def rests_within_k(self) -> float:
        """Largest steady deviation of a healthy loop above the setpoint, K."""
        return self.dead_band_k

    @property
    def full_beyond_k(self) -> float:
        """Error beyond which the duty is full while the integral is 0, K."""
        return min(self.full_percent / self.kp if self.kp else math.inf, self.on_at_k)

    @property
    def steady_percent(self) -> tuple[float, float]:
        """Lowest and highest duty at a constant reading, %."""
        integral = self.integral
        least = max(0.0, integral.minimum_percent)
        return least, min(self.full_percent, integral.maximum_percent)

    def dose(self, step_k: float, over_s: float) -> tuple[float, float]:
        """Return the duty, %, that a step of the reading causes, and for how long, s."""
        over_s += self.derivative_filter_s
        return min(self.kd * step_k / over_s, self.full_percent), over_s

    def stuck(self, below_k: float, integral_percent: float) -> Lie:
        """Return the duty while the reading is stuck below the setpoint."""
        full = self.full_percent
        kept = self.keeps_output and below_k <= self.dead_band_k  # the kept output may be full
        if kept or below_k > self.on_at_k:
            return Lie(full, 0.0, full)
        error_k = below_k if below_k > self.dead_band_k else 0.0
        proportional, most = self.kp * error_k, self.integral.maximum_percent
        if not self.ki:
            integral_percent = most = 0.0
        first = min(full, proportional + integral_percent)
        return Lie(first, self.ki * error_k, max(first, min(full, proportional + most)))

    @property
    def keeps_output(self) -> bool:
        """Whether there is a dead band in which the whole output is kept."""
        return self.dead_band_k > 0 and self.dead_band_keeps == "output"


Algorithm = Annotated[OnOff | Pid | ThreePosition, Field(discriminator="kind")]
if not TYPE_CHECKING:  # mypy knows only heatwright's own kinds
    Algorithm = with_brought("algorithm", Algorithm)
