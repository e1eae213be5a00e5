"""Loops: sensor, heater, algorithm, setpoint, and the protections about them."""

import math
from collections.abc import Iterable, Mapping
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, PrivateAttr, StrictBool, model_validator

from heatwright.spec.algorithms import Algorithm
from heatwright.spec.base import DEFAULTS, Model, Off, Reference, Temperature, WholeNumber
from heatwright.spec.quantity import Quantity, duration
from heatwright.spec.units import DIFFERENCE, DURATION, PERCENT, RATE

DEFAULT_MARGIN_K = 15.0
"""Marlin's and Klipper's margin between the highest setpoint and the maximum is 10 to 15 K."""

MOST_STEPS = 65535
"""Most steps that a 16-bit counter holds."""

_Rise = Annotated[float, Quantity(DIFFERENCE, least=0.001)]
_Time = Annotated[float, Quantity(DURATION, least=0.01)]

LONGEST_RULE_S = 86_400.0
"""A day: a rule that waits for longer protects nobody, and takes too long to simulate."""

_RuleTime = Annotated[float, Quantity(DURATION, least=0.01, most=LONGEST_RULE_S)]

LONGEST_ON_S = 604_800.0
"""A week: who needs a heater on for longer needs no limit."""


class Setpoint(Model):
    """The setpoints that the operator may choose."""

    initial_c: Temperature = Field(alias="initial", description="Setpoint after the first start.")
    minimum_c: Temperature = Field(alias="minimum", description="Lowest setpoint.")
    maximum_c: Temperature = Field(alias="maximum", description="Highest setpoint.")
    stored: StrictBool = Field(
        False, description="Keep the operator's setpoint in EEPROM while the power is off."
    )


class Limits(Model):
    """The numbers of a rule: given in the spec, usual defaults, or derived from the plant."""

    _derived: dict[str, str] = PrivateAttr(default_factory=dict)

    @property
    def derived(self) -> Mapping[str, str]:
        """How numbers were derived, in words, by their keys in the language."""
        return self._derived

    def derived_as(self, words: Mapping[str, str]) -> Self:
        """Return the rule with words that say how its numbers were derived, by their keys."""
        copy = self.model_copy()
        copy._derived = dict(words)
        return copy


class Heating(Limits):
    """Rule `heating_failed`: full power must raise the temperature."""

    rise_k: _Rise = Field(2.0, alias="rise", description="Rise that full power must bring.")
    within_s: _RuleTime = Field(
        120.0,
        alias="within",
        description="Time in which it must do so. Left out: from the plant, or 2 min.",
    )


class Runaway(Limits):
    """Rules `runaway_above` and `runaway_below`: once reached, the setpoint must be held."""

    above_k: _Rise = Field(
        10.0,
        alias="above",
        description="Deviation above it that is too large. Left out: from the plant, or 10 K.",
    )
    below_k: _Rise | None = Field(
        None, alias="below", description="Deviation below that is too large; else no such rule."
    )
    for_s: _RuleTime = Field(60.0, alias="for", description="Time it must last.")


class Frozen(Limits):
    """Rule `sensor_frozen`: with more heat than holding needs, readings must move."""

    for_s: _RuleTime = Field(
        600.0,
        alias="for",
        description="Time of such heat without a change of reading. Left out: from the plant, or "
        "10 min.",
    )
    holding_percent: Annotated[float, Quantity(PERCENT, least=0.0, most=100.0)] = Field(
        0.0,
        alias="holding",
        description="Duty that holding may need: at it a reading may stand still for ever. "
        "Left out: from the plant, or 0 %.",
    )


class RisingWhileOff(Limits):
    """Rule `rising_while_off`: with the heater off, the temperature must not climb."""

    rise_k: _Rise = Field(
        10.0,
        alias="rise",
        description="Rise above the lowest reading since. Left out: from the plant, or 10 K.",
    )
    settle_s: _RuleTime = Field(
        120.0,
        alias="settle",
        description="Time after switching off in which it may coast up. Left out: from the plant, "
        "or 2 min.",
    )


class Agreement(Limits):
    """Rule `sensors_disagree`: a second sensor must read what the loop's own sensor reads."""

    within_k: _Rise = Field(alias="within", description="Largest difference of both.")
    for_s: _RuleTime = Field(10.0, alias="for", description="Time it must last.")


class EffortLine(NamedTuple):
    """Limits of the power for a reading, %: straight lines from `from_c` to that of the next."""

    from_c: float
    high_percent: float
    high_per_k: float
    low_percent: float
    low_per_k: float

    def at(self, celsius: float) -> tuple[float, float]:
        """Return the highest and the lowest power at a reading, %."""
        return (
            self.high_percent + self.high_per_k * celsius,
            self.low_percent + self.low_per_k * celsius,
        )


class EffortBand(NamedTuple):
    """Limits of rules `effort_high` and `effort_low`, derived from a plant.

    filter_s -- time for which the plant feels a power; move_k -- a smaller change counts as none.
    """

    filter_s: float
    move_k: float
    lines: tuple[EffortLine, ...]

    def at(self, celsius: float) -> tuple[float, float]:
        """Return the highest and the lowest power at a reading, %."""
        reached = [line for line in self.lines if line.from_c <= celsius]
        return (reached or self.lines)[-1 if reached else 0].at(celsius)


_High = Annotated[float, Quantity(PERCENT, least=100.0, most=1000.0)]
_Low = Annotated[float, Quantity(PERCENT, least=0.1, most=100.0)]


class Effort(Limits):
    """Rules `effort_high` and `effort_low`: the power fits the reading."""

    high_percent: Annotated[_High | None, Off] = Field(
        None,
        alias="high",
        description="Highest power of a healthy machine, as a share of what the plant needs for a "
        "reading in winter, or `off`. Left out: from the plant's tolerance.",
    )
    low_percent: Annotated[_Low | None, Off] = Field(
        None,
        alias="low",
        description="Lowest power, as a share of what the plant needs in summer, or `off`. Left "
        "out: from the plant's tolerance.",
    )
    for_s: _RuleTime = Field(
        3600.0, alias="for", description="Time it must last. Left out: from the plant."
    )

    _band: EffortBand | None = PrivateAttr(default=None)

    @property
    def band(self) -> EffortBand:
        """The limits derived from the plant; `check` refuses these rules without a plant."""
        if self._band is None:
            message = "the rules of effort need a plant"
            raise ValueError(message)
        return self._band

    @property
    def has_band(self) -> bool:
        """Whether limits have been derived from the plant."""
        return self._band is not None

    def with_band(self, band: EffortBand) -> Self:
        """Return the rule with limits that are derived from the plant."""
        copy = self.model_copy()
        copy._band = band
        return copy


class Protection(Model):
    """The rules that switch the heater off and keep it off until somebody acknowledges."""

    # The loop sets the default, because only the loop knows its highest setpoint.
    maximum_c: Temperature = Field(
        math.inf,
        alias="maximum",
        description="Rule `over_temperature`. Left out: the highest setpoint plus 15 K.",
    )
    maximum_adjustable: StrictBool = Field(
        False, description="Let the operator lower the maximum; it is kept in EEPROM."
    )
    minimum_c: Temperature = Field(
        -10.0, alias="minimum", description="Rule `under_temperature`: a colder reading is wrong."
    )
    rise_rate_k_per_s: Annotated[float, Quantity(RATE, least=0.0001)] = Field(
        5.0,
        alias="rise_rate",
        description="Rule `rise_rate`: a faster change, up or down, is wrong.",
    )
    heating: Annotated[Heating | None, Off] = Field(
        DEFAULTS, validate_default=True, description="Rule `heating_failed`, or `off`."
    )
    runaway: Annotated[Runaway | None, Off] = Field(
        DEFAULTS,
        validate_default=True,
        description="Rules `runaway_above` and `runaway_below`, or `off`.",
    )
    stale_after_s: _Time = Field(
        5.0,
        alias="stale_after",
        description="Time without a good reading until it is a fault; the heater is off at once.",
    )
    frozen: Annotated[Frozen | None, Off] = Field(
        DEFAULTS, validate_default=True, description="Rule `sensor_frozen`, or `off`."
    )
    rising_while_off: Annotated[RisingWhileOff | None, Off] = Field(
        DEFAULTS, validate_default=True, description="Rule `rising_while_off`, or `off`."
    )
    # The controller sets the default, because only it knows the plant.
    effort: Annotated[Effort | None, Off] = Field(
        None,
        description="Rules `effort_high` and `effort_low`, or `off`. Left out: on where there is a "
        "plant, and more than 16 KB of flash.",
    )
    # The controller sets the default, because only it knows who commands the loop.
    master_lost_after_s: Annotated[_Time | None, Off] = Field(
        None,
        alias="master_lost_after",
        description="Rule `master_lost`: time without a master's request, or a host's line, while "
        "the loop is on. Left out: 10 min under a host of G-code, else no such rule.",
    )
    agreement: Agreement | None = Field(
        None, description="Rule `sensors_disagree`; needed with `also`, and only there."
    )
    on_for_at_most_s: (
        Annotated[float, Quantity(DURATION, least=600.0, most=LONGEST_ON_S)] | None
    ) = Field(
        None,
        alias="on_for_at_most",
        description="Rule `on_too_long`: time that the loop may be on without being switched off; "
        "left out: no such rule.",
    )


class Autotune(Model):
    """A relay experiment, started by command, that finds the gains."""

    cycles: Annotated[int, WholeNumber("a number of cycles", 3, 20, 5)] = Field(
        5, description="Oscillations of the experiment."
    )
    swing_percent: Annotated[float, Quantity(PERCENT, least=1.0, most=100.0)] = Field(
        100.0, alias="swing", description="Duty below the target, of the output's maximum."
    )
    timeout_s: _Time = Field(
        1200.0, alias="timeout", description="Time after which the experiment is given up."
    )


class Response(Model):
    """Settling time and overshoot after the last change of setpoint, measured by the firmware."""

    within_k: _Rise = Field(
        alias="within", description="Deviation within which the temperature has settled."
    )
    for_s: _Time = Field(60.0, alias="for", description="Time it must stay within.")


class Loop(Model):
    """One temperature held by one heater."""

    sensor: Reference = Field(description="Sensor that measures the temperature.")
    also: Reference | None = Field(
        None, description="Monitor whose sensor measures the same; the loop heats only with both."
    )
    heater: Reference = Field(description="Output that heats.")
    fan: Reference | None = Field(
        None, description="Digital output without which the heater must not be on."
    )
    cooler: Reference | None = Field(
        None, description="Digital output that cools; never on together with the heater."
    )
    starts: Literal["enabled", "disabled"] | None = Field(
        None,
        description="State after the power-up of a loop that somebody can switch on; left out: "
        "`disabled`.",
    )
    period_s: _Time = Field(
        alias="period", description="Time between control steps; a multiple of the 10 ms tick."
    )
    setpoint: Setpoint = Field(description="The range of the setpoint.")
    algorithm: Algorithm = Field(description="How the heater's duty follows from the error.")
    autotune: Autotune | None = Field(
        None, description="Let a command tune the gains; left out, none can."
    )
    ready_within_k: _Rise | None = Field(
        None,
        alias="ready_within",
        description="Deviation up to which the loop is ready; a feed waits for that.",
    )
    response: Response | None = Field(
        None, description="Measure settling time and overshoot; left out: not measured."
    )
    protection: Protection = Field(
        DEFAULTS,
        validate_default=True,
        description="The rules that stop the heater; all are on by default.",
    )

    @property
    def period_ticks(self) -> int:
        """The period in ticks of 10 ms."""
        return round(self.period_s * 100)

    @property
    def told_period(self) -> str:
        """The period as a message says it."""
        return duration(self.period_s)

    @property
    def rise_per_period_k(self) -> float:
        """The most by which rule `rise_rate` lets a reading change from one step to the next, K."""
        return self.protection.rise_rate_k_per_s * self.period_s

    def periods_s(self, count: float) -> float:
        """Return the time of `count` periods, s."""
        return count * self.period_s

    def periods_in(self, seconds: float) -> float:
        """Return how many periods a time is, with the part of one that is left over."""
        return seconds / self.period_s

    def next_step_s(self, after_s: float) -> float:
        """Return the time by which the next step has come after a time, at the latest, s."""
        return after_s + self.period_s

    def rate_k_per_s(self, change_k: float) -> float:
        """Return how fast a change from one step to the next looks, K/s."""
        return change_k / self.period_s

    def has_time_for(self, seconds: float) -> bool:
        """Return whether a period is long enough for something."""
        return self.period_s >= seconds

    def integral(self, total: float) -> float:
        """Return the integral over time, in s, of a value whose sum over the steps is `total`."""
        return total * self.period_s

    @model_validator(mode="after")
    def _default_maximum(self) -> "Loop":
        if math.isfinite(self.protection.maximum_c):
            return self
        maximum_c = self.setpoint.maximum_c + DEFAULT_MARGIN_K
        protection = self.protection.model_copy(update={"maximum_c": maximum_c})
        return self.model_copy(update={"protection": protection})


def shortest_period_s(loops: Iterable[Loop]) -> float:
    """Return the shortest period of loops, s; infinite if there are none."""
    return min((loop.period_s for loop in loops), default=math.inf)
