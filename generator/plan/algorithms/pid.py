"""PID control: terms with a zero gain are left out, unless gains can be set."""

from dataclasses import dataclass
from typing import NamedTuple

from heatwright.generator.plan.algorithms.common import (
    AlgorithmPlan,
    by_keys,
    filter_weight,
    least_slope,
    per_period,
    per_step,
    period,
)
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, Pid, facts_of
from heatwright.spec.adjusted import GAINS
from heatwright.spec.algorithms import LEAST_RANGE_PERCENT, Algorithm, IntegralLimits, OutputLimits


def plan(source: Source, name: str, loop: Loop, prefix: str) -> AlgorithmPlan:
    """Plan the algorithm of loop `name`."""
    assert isinstance(loop.algorithm, Pid)  # noqa: S101 - the kind selects this plan
    facts = facts_of(source.controller, name)
    terms = _Terms(
        source,
        loop.algorithm,
        prefix,
        loop,
        variable=facts.gains_vary,
        moved=facts.programmed and loop.algorithm.feed_forward > 0,
    )
    gain = {
        each: f"settings.{name}_{each}"
        if facts.tunable or each in by_keys(source, name)
        else f"{prefix}_{each.upper()}"
        for each in GAINS
    }
    maximum = loop.algorithm.output.maximum_percent
    return AlgorithmPlan(
        template="algorithms/pid",
        told=terms.names(f"algorithm_{name}", gain),
        constants=tuple(terms.constants()),
        full_duty=source.at("output", "maximum").given(f"{prefix}_FULL_DUTY_PERCENT", maximum, "%"),
    )


class LimitsInForce(NamedTuple):
    """C names of the limits, %: constants, or members of the loop if a host may narrow them."""

    integral_minimum: str
    integral_maximum: str
    output_maximum: str


def in_force(algorithm: Algorithm, prefix: str, state: str) -> LimitsInForce:
    """Name the limits of the loop whose state is called `state` in C."""
    names = LimitsInForce._fields
    if algorithm.limits_adjustable:
        return LimitsInForce(*(f"{state}.{name}_percent" for name in names))
    return LimitsInForce(*(f"{prefix}_{name.upper()}" for name in names))


@dataclass(frozen=True, slots=True)
class PidNames:
    """The values for the templates: the terms, and their numbers in C.

    hold -- the integral is held while the output is limited; moved -- a program moves the setpoint;
    of_error -- the derivative is that of the error; late -- it is used one step later; newest -- C
    name of the slope of this step; keeps -- the dead band keeps the output.
    """

    where: str
    integral_minimum: str
    integral_maximum: str
    output_maximum: str
    gain: dict[str, str]
    where_of: dict[str, str]
    variable: bool
    integral: bool
    hold: bool
    derivative: bool
    moved: bool
    of_error: bool
    band: bool
    late: bool
    newest: str
    dead_band: bool
    keeps: bool
    kp: str
    kd: str
    ki_per_step: str


@dataclass(frozen=True, slots=True)
class _Terms:
    source: Source
    pid: Pid
    prefix: str
    loop: Loop
    variable: bool
    """True if gains can be set: by a host, a master or the keypad."""
    moved: bool
    """True if a program sets the setpoint, whose slope has a term of its own."""

    @property
    def integral(self) -> bool:
        return self.variable or self.pid.ki > 0

    @property
    def derivative(self) -> bool:
        return self.variable or self.pid.kd > 0

    def names(self, state: str, gain: dict[str, str]) -> PidNames:
        """Return the template's values; gains that may change are members of `state`."""
        limits = in_force(self.pid, self.prefix, f"loop_{state.removeprefix('algorithm_')}")
        keys = (
            "kd", "feed_forward", "integral", "band", "dead_band", "dead_band_keeps",
            "derivative_step",
        )  # fmt: skip
        return PidNames(
            where=self.source.where,
            integral_minimum=limits.integral_minimum,
            integral_maximum=limits.integral_maximum,
            output_maximum=limits.output_maximum,
            gain=gain,
            where_of={key: self.source.at(key).where for key in keys},
            variable=self.variable,
            integral=self.integral,
            hold=self.pid.integral.while_limited == "hold",
            derivative=self.derivative,
            moved=self.moved,
            of_error=self.pid.derivative_of == "error",
            band=self.pid.band_k is not None,
            late=self.pid.derivative_step == "previous",
            newest="slope" if self.pid.derivative_step == "previous" else "derivative",
            dead_band=self.pid.dead_band_k > 0,
            keeps=self.pid.keeps_output,
            kp=f"{state}.kp" if self.variable else f"{self.prefix}_KP",
            kd=f"{state}.kd" if self.variable else f"{self.prefix}_KD",
            ki_per_step=f"{state}.ki * {self.prefix}_PERIOD_S"
            if self.variable
            else f"{self.prefix}_KI_PER_STEP",
        )

    def constants(self) -> list[Constant]:
        """Return the constants, in the order in which the terms are added."""
        constants = [self._number("kp", "KP", self.pid.kp, "%/K")]
        if self.integral:
            constants += [*self._ki(), *self._limits("integral", self.pid.integral)]
        if self.derivative:
            constants += self._kd()
        if self.moved:
            constants.append(
                self._number("feed_forward", "FEED_FORWARD", self.pid.feed_forward, "%*s/K")
            )
        constants += self._limits("output", self.pid.output)
        if self.pid.limits_adjustable:
            at, name = self.source.at("limits_adjustable"), f"{self.prefix}_OUTPUT_LEAST_MAXIMUM"
            least = self.pid.output.minimum_percent + LEAST_RANGE_PERCENT
            constants.append(at.number(name, least, "the least that a host may set"))
        if self.pid.band_k is not None:
            constants.append(self._number("band", "BAND_K", self.pid.band_k, "K"))
        if self.pid.dead_band_k > 0:
            constants.append(self._number("dead_band", "DEAD_BAND_K", self.pid.dead_band_k, "K"))
        return constants

    def _number(self, key: str, name: str, value: float, unit: str) -> Constant:
        return self.source.at(key).given(f"{self.prefix}_{name}", value, unit)

    def _ki(self) -> list[Constant]:
        unit = "%/(K*s)"
        if self.variable:
            return [
                self._number("ki", "KI", self.pid.ki, unit),
                period(self._of_loop(), f"{self.prefix}_PERIOD_S", self.loop),
            ]
        name = f"{self.prefix}_KI_PER_STEP"
        return [per_step(self.source.at("ki"), name, self.pid.ki, unit, self.loop)]

    def _kd(self) -> list[Constant]:
        at, name = self.source.at("derivative_filter"), f"{self.prefix}_SLOPE_WEIGHT"
        return [
            self._number("kd", "KD", self.pid.kd, "%*s/K"),
            filter_weight(at, name, self.pid.derivative_filter_s, self.loop),
            least_slope(at, self.prefix),
            per_period(self._of_loop(), self.prefix, self.loop),
        ]

    def _limits(self, section: str, limits: IntegralLimits | OutputLimits) -> list[Constant]:
        name = f"{self.prefix}_{section.upper()}"
        bounds = {"minimum": limits.minimum_percent, "maximum": limits.maximum_percent}
        return [
            self.source.at(section, key).given(f"{name}_{key.upper()}", value, "%")
            for key, value in bounds.items()
        ]

    def _of_loop(self) -> Source:
        return Source(self.source.spec, self.source.path[:-1])
