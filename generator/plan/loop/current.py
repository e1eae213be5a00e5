"""The current of a heater: its limit, its rules, and their constants."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, in_periods, quantity, steps
from heatwright.generator.plan.parts import Constant, Group, Part, pair
from heatwright.generator.plan.source import Source
from heatwright.spec import Current, Loop, facts_of
from heatwright.spec.sensing.circuits import reference_v

RAMP_PERCENT = 25.0
"""Initial limit of the duty, and its rise per step, %: so a wire with a third of its resistance is
detected at three quarters of its rated current, before it carries more."""

RULES_S = 0.5
"""Time for which the current must be too high or too low to trip a rule."""

LEAST_PERCENT = 0.1
"""Lowest limit of the duty, %: a wire that needs a lower one trips a rule anyway, and the square of
a lower one might not be a normal number."""

FEWEST_STEPS = 5
"""Minimum number of control steps in RULES_S: with a filter time constant of up to one step, less
than 2 % of an old value is left after four steps."""

IDLE_SHARE = 0.05
"""Share of the mean nominal current at full duty below which a reading means no current."""

IDLE_CODES = 3
"""ADC steps below which a reading also means no current: offset and linearity errors are within
them (data sheets, ADC characteristics)."""


@dataclass(frozen=True, slots=True)
class CurrentNames:
    """The values for the templates of a heater's current."""

    name: str
    heater: str
    HEATER: str
    sensor: str
    limited: bool
    where: str
    limit_where: str


def plan_current(source: Source, name: str, loop: Loop) -> Part:
    """Plan limit and rules for the current of loop `name`'s heater, if it is measured."""
    current = facts_of(source.controller, name).current
    if current is None:
        return Part()
    at = Source(source.spec, ("outputs", loop.heater)).at("current")
    prefix = f"CURRENT_{loop.heater.upper()}"
    context = CurrentNames(
        name=name,
        heater=loop.heater,
        HEATER=loop.heater.upper(),
        sensor=current.sensor,
        limited=current.limit_a is not None,
        where=at.where,
        limit_where=at.at("limit").where,
    )
    return Part(
        files=pair(f"current_{loop.heater}", "protection/current", context),
        groups=(Group(f"Current of {loop.heater}", tuple(_constants(at, loop, current, prefix))),),
    )


def _constants(at: Source, loop: Loop, current: Current, prefix: str) -> list[Constant]:
    heater = at.controller.switches[loop.heater]
    assert heater.power_w is not None and heater.supply_v is not None  # noqa: S101, PT018 - checked
    power, supply = quantity(heater.power_w, "W"), quantity(heater.supply_v, "V")
    factor, mean = 1.0, ""
    if heater.rated_v is not None:
        factor = heater.mean_of_rms
        mean = f" rms x {quantity(heater.rated_v, 'V')} / {supply}"
    idle_a, idle_words = _idle(at, current, factor, mean)
    limit = []
    if current.limit_a is not None:
        shown = f"{quantity(current.limit_a, 'A')}{mean or ' rms'}: its mean at full duty"
        bound, ramp = at.at("limit"), "initial limit, and its rise per step"
        limit = [
            bound.number(f"{prefix}_LIMIT_A", current.limit_a * factor, shown),
            bound.number(f"{prefix}_RAMP_PERCENT", RAMP_PERCENT, ramp),
            bound.number(f"{prefix}_LEAST_PERCENT", LEAST_PERCENT, "the lowest limit of the duty"),
        ]
    over = f"{quantity(current.over_a, 'A')}{mean or ' rms'}: its mean at full duty"
    return [
        *limit,
        at.at("trip").number(f"{prefix}_TRIP_A", current.over_a * factor, over),
        at.number(f"{prefix}_IDLE_A", idle_a, idle_words),
        at.number(
            f"{prefix}_AMPERES_PER_PERCENT",
            heater.power_w / heater.supply_v / 100,
            f"{power} / {supply} / 100 %",
        ),
        at.count(f"{prefix}_STEPS", *_steps(loop)),
    ]


def _idle(at: Source, current: Current, factor: float, mean: str) -> tuple[float, str]:
    sensor = at.controller.ammeters[current.sensor]
    share_a = IDLE_SHARE * current.nominal_a * factor
    full_v = reference_v(sensor, at.controller.board.mcu)
    codes_a = IDLE_CODES * full_v / 1024 / sensor.scale_v_per_a
    if codes_a > share_a:
        return codes_a, f"{IDLE_CODES} steps of the ADC: less means no current"
    nominal = quantity(current.nominal_a, "A") + mean
    return share_a, f"{IDLE_SHARE:.0%} of {nominal}: less means no current"


def _steps(loop: Loop) -> tuple[int, str]:
    enough = steps(RULES_S, loop)
    if enough < FEWEST_STEPS:
        return FEWEST_STEPS, f"its filter may lag by a step of {loop.period_ticks * TICK_MS} ms"
    return enough, in_periods(RULES_S, loop)
