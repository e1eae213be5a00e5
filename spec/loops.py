"""Loops: sensor, heater, algorithm, setpoint, and their protections."""

import math
from collections.abc import Iterable, Mapping
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, PrivateAttr, StrictBool, model_validator

from heatwright.spec.algorithms import Algorithm
from heatwright.spec.base import DEFAULTS, Model, Off, Reference, Temperature, WholeNumber
from heatwright.spec.quantity import Quantity, duration
from heatwright.spec.units import DIFFERENCE, DURATION, PERCENT, RATE

DEFAULT_MARGIN_K = 15.0
"""Default of the maximum above the highest setpoint; Marlin and Klipper have 10 to 15 K."""

MOST_STEPS = 65535
"""Maximum number of steps: a 16-bit counter counts them."""

_Rise = Annotated[float, Quantity(DIFFERENCE, least=0.001)]
_Time = Annotated[float, Quantity(DURATION, least=0.01)]

LONGEST_RULE_S = 86_400.0
"""A day: a rule that waits for longer protects nothing, and its simulation takes too long."""

_RuleTime = Annotated[float, Quantity(DURATION, least=0.01, most=LONGEST_RULE_S)]

LONGEST_ON_S = 604_800.0
"""A week: a heater that has to be on for longer needs no limit."""


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
        """Explanations of the derived numbers, by their keys in the spec."""
        return self._derived

    def derived_as(self, words: Mapping[str, str]) -> Self:
        """Return the rule with explanations of its derived numbers, by their keys."""
        copy = self.model_copy()
        copy._derived = dict(words)
        return copy


class Heating(Limits):
    """Rule `heating_failed`: full power must raise the temperature."""

    rise_k: _Rise = Field(2.0, alias="rise", description="Rise that full power must cause.")
    within_s: _RuleTime = Field(
        120.0,
        alias="within",
        description="Time for that rise. Default: derived from the plant; without one 2 min.",
    )


class Runaway(Limits):
    """Rules `runaway_above` and `runaway_below`: the setpoint, once reached, must be held."""

    above_k: _Rise = Field(
        10.0,
        alias="above",
        description="Largest deviation above the setpoint. Default: from the plant, or 10 K.",
    )
    below_k: _Rise | None = Field(
        None, alias="below", description="Largest deviation below the setpoint. Default: none."
    )
    for_s: _RuleTime = Field(60.0, alias="for", description="How long the deviation must last.")


class Frozen(Limits):
    """Rule `sensor_frozen`: at more power than holding the setpoint needs, readings must change."""

    for_s: _RuleTime = Field(
        600.0,
        alias="for",
        description="How long the duty may be above `holding` while the reading does not change. "
        "Default: derived from the plant; without one 10 min.",
    )
    holding_percent: Annotated[float, Quantity(PERCENT, least=0.0, most=100.0)] = Field(
        0.0,
        alias="holding",
        description="Duty that holding the setpoint may need: up to it a reading may be constant. "
        "Default: derived from the plant; without one 0 %.",
    )


class RisingWhileOff(Limits):
    """Rule `rising_while_off`: with the heater off, the temperature must not rise."""

    rise_k: _Rise = Field(
        10.0,
        alias="rise",
        description="Rise above the lowest reading so far. Default: from the plant, or 10 K.",
    )
    settle_s: _RuleTime = Field(
        120.0,
        alias="settle",
        description="Time after switching off in which the reading may rise. Default: derived from "
        "the plant; without one 2 min.",
    )


class Agreement(Limits):
    """Rule `sensors_disagree`: a second sensor must read the same temperature as the loop's."""

    within_k: _Rise = Field(alias="within", description="Largest difference of the readings.")
    for_s: _RuleTime = Field(10.0, alias="for", description="How long the difference must last.")


class EffortLine(NamedTuple):
    """Limits of the power for a reading, %: each line begins at `from_c`, and ends at the next."""

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

    filter_s -- mean response time to a change of power; move_k -- smaller changes are ignored, K.
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
    """Rules `effort_high` and `effort_low`: the power must fit the reading."""

    high_percent: Annotated[_High | None, Off] = Field(
        None,
        alias="high",
        description="Highest power of a healthy machine, as a share of what the plant needs for a "
        "reading in winter, or `off`. Default: derived from the plant's tolerance.",
    )
    low_percent: Annotated[_Low | None, Off] = Field(
        None,
        alias="low",
        description="Lowest power of a healthy machine, as a share of what the plant needs for a "
        "reading in summer, or `off`. Default: derived from the plant's tolerance.",
    )
    for_s: _RuleTime = Field(
        3600.0, alias="for", description="Time beyond a limit to a trip. Default: from the plant."
    )

    _band: EffortBand | None = PrivateAttr(default=None)

    @property
    def band(self) -> EffortBand:
        """The limits derived from the plant; `check` refuses these rules without a plant."""
        if self._band is None:
            message = "the rules effort_high and effort_low need simulation.plant"
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
        description="Rule `over_temperature`. Default: the highest setpoint plus 15 K.",
    )
    maximum_adjustable: StrictBool = Field(
        False, description="Let the operator lower `maximum`; the value is kept in EEPROM."
    )
    minimum_c: Temperature = Field(
        -10.0,
        alias="minimum",
        description="Rule `under_temperature`: readings at or below it are wrong.",
    )
    rise_rate_k_per_s: Annotated[float, Quantity(RATE, least=0.0001)] = Field(
        5.0,
        alias="rise_rate",
        description="Rule `rise_rate`: a faster change of the reading is wrong.",
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
        description="Longest time without a valid reading; meanwhile the heater is off.",
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
        description="Rules `effort_high` and `effort_low`, or `off`. Default: on with a plant and "
        "more than 16 KB of flash.",
    )
    # The controller sets the default, because only it knows who commands the loop.
    master_lost_after_s: Annotated[_Time | None, Off] = Field(
        None,
        alias="master_lost_after",
        description="Rule `master_lost`: time without a master's request, or a host's line, while "
        "the loop is on. Default: 10 min with a host (`gcode`), otherwise no such rule.",
    )
    agreement: Agreement | None = Field(
        None, description="Rule `sensors_disagree`: needed with `also`, refused without it."
    )
    on_for_at_most_s: (
        Annotated[float, Quantity(DURATION, least=600.0, most=LONGEST_ON_S)] | None
    ) = Field(
        None,
        alias="on_for_at_most",
        description="Rule `on_too_long`: time that the loop may be on without being switched off. "
        "Default: no such rule.",
    )


class Autotune(Model):
    """A relay experiment that a command starts and that finds the gains."""

    cycles: Annotated[int, WholeNumber("a number of cycles", 3, 20, 5)] = Field(
        5, description="Number of oscillations in the experiment."
    )
    swing_percent: Annotated[float, Quantity(PERCENT, least=1.0, most=100.0)] = Field(
        100.0, alias="swing", description="Duty below the target, in % of the output's maximum."
    )
    timeout_s: _Time = Field(
        1200.0, alias="timeout", description="Time after which the experiment is given up."
    )


class Response(Model):
    """Settling time and overshoot after the last change of setpoint, measured by the firmware."""

    within_k: _Rise = Field(
        alias="within", description="Deviation within which the temperature has settled."
    )
    for_s: _Time = Field(60.0, alias="for", description="How long the deviation must be so small.")


class Loop(Model):
    """One temperature held by one heater."""

    sensor: Reference = Field(description="Sensor that measures the temperature.")
    also: Reference | None = Field(
        None, description="Monitor of the same temperature; the loop heats only with both sensors."
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
        description="State of the loop after the power-up. Default for a loop that somebody can "
        "switch on: `disabled`.",
    )
    period_s: _Time = Field(
        alias="period", description="Time between control steps; a multiple of the 10 ms tick."
    )
    setpoint: Setpoint = Field(description="The range of the setpoint.")
    algorithm: Algorithm = Field(description="How the heater's duty follows from the error.")
    autotune: Autotune | None = Field(
        None, description="Let a host or a master tune the gains by a command."
    )
    ready_within_k: _Rise | None = Field(
        None,
        alias="ready_within",
        description="Deviation up to which the loop is ready; a feed waits until it is ready.",
    )
    response: Response | None = Field(
        None, description="Measure settling time and overshoot. Default: not measured."
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
        """The period, formatted for a message."""
        return duration(self.period_s)

    @property
    def rise_per_period_k(self) -> float:
        """Largest change of a reading from one step to the next that rule `rise_rate` allows, K."""
        return self.protection.rise_rate_k_per_s * self.period_s

    @property
    def settles_below(self) -> bool:
        """Whether the temperature may settle below the setpoint, where part of the power holds."""
        return self.algorithm.continuous and not self.algorithm.has_integral

    def periods_s(self, count: float) -> float:
        """Return the time of `count` periods, s."""
        return count * self.period_s

    def periods_in(self, seconds: float) -> float:
        """Return a time as a number of periods, with its fraction."""
        return seconds / self.period_s

    def next_step_s(self, after_s: float) -> float:
        """Return the latest time of the next step after a time, s."""
        return after_s + self.period_s

    def rate_k_per_s(self, change_k: float) -> float:
        """Return the rate of a change from one step to the next, K/s."""
        return change_k / self.period_s

    def has_time_for(self, seconds: float) -> bool:
        """Return whether a period is at least this long."""
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
