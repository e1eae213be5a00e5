"""The constants of a loop's protections."""

from dataclasses import dataclass

from heatwright.generator.plan.algorithms.common import per_step
from heatwright.generator.plan.numbers import c_float, filter_share, quantity
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import derivation_words
from heatwright.spec import Loop, Protection
from heatwright.spec.loops import Effort, Limits
from heatwright.spec.quantity import about


def guard_constants(source: Source, loop: Loop, prefix: str, full_duty: Constant) -> list[Constant]:
    """Limits and times of the rules that the loop has; `source` is its `protection`."""
    rules = loop.protection

    def count(path: tuple[str, ...], name: str, duration_s: float) -> Constant:
        more = _from_plant(rules, path)
        return source.at(*path).steps(f"{prefix}_{name}", duration_s, loop, more)

    def number(path: tuple[str, ...], name: str, value: float, unit: str) -> Constant:
        return source.at(*path).given(f"{prefix}_{name}", value, unit, _from_plant(rules, path))

    constants = [
        number(("maximum",), "MAXIMUM_C", rules.maximum_c, "degC"),
        number(("minimum",), "MINIMUM_C", rules.minimum_c, "degC"),
        per_step(
            source.at("rise_rate"),
            f"{prefix}_RISE_PER_STEP_K",
            rules.rise_rate_k_per_s,
            "K/s",
            loop,
        ),
        count(("stale_after",), "STALE_STEPS", rules.stale_after_s),
    ]
    if rules.agreement is not None:
        constants += [
            number(("agreement", "within"), "AGREEMENT_K", rules.agreement.within_k, "K"),
            count(("agreement", "for"), "AGREEMENT_STEPS", rules.agreement.for_s),
        ]
    constants += _times_on(source, loop, prefix)
    runaway = rules.runaway
    if runaway is not None:
        constants.append(number(("runaway", "above"), "RUNAWAY_ABOVE_K", runaway.above_k, "K"))
        if runaway.below_k is not None:
            constants.append(number(("runaway", "below"), "RUNAWAY_BELOW_K", runaway.below_k, "K"))
        constants.append(count(("runaway", "for"), "RUNAWAY_STEPS", runaway.for_s))
    if rules.heating is not None:
        constants += [
            *([] if loop.algorithm.limits_adjustable else [full_duty]),
            number(("heating", "rise"), "HEATING_RISE_K", rules.heating.rise_k, "K"),
            count(("heating", "within"), "HEATING_STEPS", rules.heating.within_s),
        ]
    if rules.frozen is not None:
        percent = rules.frozen.holding_percent
        holding = number(("frozen", "holding"), "FROZEN_HOLDING_PERCENT", percent, "%")
        constants += [holding] if percent > 0 else []
        constants.append(count(("frozen", "for"), "FROZEN_STEPS", rules.frozen.for_s))
    if rules.rising_while_off is not None:
        rising = rules.rising_while_off
        constants += [
            number(("rising_while_off", "rise"), "OFF_RISE_K", rising.rise_k, "K"),
            count(("rising_while_off", "settle"), "OFF_SETTLE_STEPS", rising.settle_s),
        ]
    if rules.effort is not None:
        constants += _effort(source.at("effort"), rules.effort, loop, prefix)
    return constants


def _times_on(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    """How long the loop may be on without a sign of its host or master, and in total."""
    lost_s, most_s = loop.protection.master_lost_after_s, loop.protection.on_for_at_most_s
    constants = []
    if lost_s is not None:
        constants.append(
            source.at("master_lost_after").ticks(f"{prefix}_MASTER_LOST_TICKS", lost_s)
        )
    if most_s is not None:
        constants.append(source.at("on_for_at_most").steps(f"{prefix}_ON_STEPS", most_s, loop))
    return constants


@dataclass(frozen=True, slots=True)
class LineNames:
    """A straight line that limits the power, in C: value at 0 degC, and slope per kelvin."""

    percent: str
    per_k: str


@dataclass(frozen=True, slots=True)
class EffortNames:
    """The band of the power in C: constants, or a table if the band has several lines.

    columns -- the table's columns after the temperature; lines -- its rows; high, low -- the band's
    ends, None without the rule; cooled -- the loop has a cooler.
    """

    columns: list[str]
    lines: list[list[str]]
    high: LineNames | None
    low: LineNames | None
    cooled: bool


def effort_names(loop: Loop, prefix: str) -> EffortNames | None:
    """Name the lines of the band; None without the rules."""
    effort = loop.protection.effort
    if effort is None:
        return None
    lines, ends = effort.band.lines, _ends(effort)
    columns = [f"{end}_{part}" for end in ends for part in ("percent", "per_k")]
    bends = len(lines) > 1

    def named(end: str) -> LineNames | None:
        if end not in ends:
            return None
        name = f"pgm_read_float(&effort_lines[i].{end}_" if bends else f"{prefix}_EFFORT_{end}_"
        percent, per_k = f"{name}percent", f"{name}per_k"
        if bends:
            return LineNames(f"{percent})", f"{per_k})")
        return LineNames(percent.upper(), per_k.upper())

    return EffortNames(
        columns=columns,
        lines=[
            [c_float(each.from_c), *(c_float(getattr(each, column)) for column in columns)]
            for each in lines
        ],
        high=named("high"),
        low=named("low"),
        cooled=loop.cooler is not None,
    )


def _ends(effort: Effort) -> dict[str, tuple[float, str]]:
    """Return the band's ends, each with its share of the plant's power, %, and its season."""
    ends = {"high": (effort.high_percent, "winter"), "low": (effort.low_percent, "summer")}
    return {end: (share, season) for end, (share, season) in ends.items() if share is not None}


def _effort(source: Source, effort: Effort, loop: Loop, prefix: str) -> list[Constant]:
    """Constants of the band of the power (a table if it has several lines), and of its time."""
    band, (line, *bent) = effort.band, effort.band.lines
    limits = []
    for end, (share, season) in _ends(effort).items() if not bent else ():
        words = (
            f"{quantity(share, '%')} of the plant's power in {season}, % of full power per K"
            f"{derivation_words(effort.derived.get(end))}"
        )
        name, at = f"{prefix}_EFFORT_{end.upper()}", source.at(end)
        limits += [
            at.number(f"{name}_PER_K", getattr(line, f"{end}_per_k"), words),
            at.number(f"{name}_PERCENT", getattr(line, f"{end}_percent"), "the same at 0 degC, %"),
        ]
    return [
        *limits,
        source.number(
            f"{prefix}_EFFORT_SHARE",
            filter_share(band.filter_s, loop),
            f"weight of a step in the mean of the power, over {about(band.filter_s)} s",
        ),
        source.number(f"{prefix}_EFFORT_MOVE_K", band.move_k, "a smaller change is ignored"),
        source.at("for").steps(
            f"{prefix}_EFFORT_STEPS",
            effort.for_s,
            loop,
            derivation_words(effort.derived.get("for")),
        ),
    ]


def _from_plant(protection: Protection, path: tuple[str, ...]) -> str:
    """Say how a number was derived from the plant; empty if it was not."""
    limits = getattr(protection, path[0], None)
    return derivation_words(limits.derived.get(path[-1])) if isinstance(limits, Limits) else ""
