"""The language of a campaign's file, and what is varied without one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, NamedTuple

from numpy.random import Generator
from pydantic import Field, model_validator

from heatwright.spec.base import ABSOLUTE_ZERO_C, MOST_ENTRIES, Model, ReadOnly, Reference
from heatwright.spec.problems import Checked, refuse
from heatwright.spec.quantity import Quantity, tidy
from heatwright.spec.units import (
    CAPACITY,
    DIFFERENCE,
    DURATION,
    PERCENT,
    TEMPERATURE,
    THERMAL_RESISTANCE,
    Dimension,
)

SIGMAS = 3.0
"""A normal quantity beyond so many standard deviations is drawn again: such a part is not sold."""

_AROUND = re.compile(r"(±|\+/?-|normal\b)\s*(.*)", re.DOTALL)


class Spread(NamedTuple):
    """A distribution of a quantity in base units.

    values -- `within`: the half width, `normal`: the standard deviation, both around the quantity's
    nominal value; `between`: both ends; `one_of`: all values. is_share -- whether the half width is
    a share of the nominal value. text -- as written in the file.
    """

    how: Literal["within", "normal", "between", "one_of"]
    values: tuple[float, ...]
    is_share: bool
    text: str

    def ends(self, own: float = 0.0) -> tuple[float, float]:
        """Return the lowest and the highest value that can be drawn, for a nominal value."""
        if self.how not in {"within", "normal"}:  # not centred on the nominal value
            return min(self.values), max(self.values)
        half = self.values[0] * (abs(own) if self.is_share else 1.0)
        half *= SIGMAS if self.how == "normal" else 1.0
        return own - half, own + half

    def draw(self, random: Generator, own: float = 0.0) -> float:
        """Draw a value, for a nominal value."""
        if self.how == "one_of":
            return self.values[int(random.integers(len(self.values)))]
        low, high = self.ends(own)
        if self.how != "normal":
            return low + (high - low) * float(random.random())
        sigmas = SIGMAS + 1
        while abs(sigmas) > SIGMAS:
            sigmas = float(random.standard_normal())
        return own + sigmas * (high - own) / SIGMAS


class Spreads(Checked):
    """Marks a field with a distribution: `Annotated[Spread, Spreads(CAPACITY)]`.

    own -- whether the quantity has a nominal value, as ± and normal need; shares -- whether their
    width may be a share of it.
    """

    def __init__(
        self, dimension: Dimension, *, least: float | None = None, own: bool = True,
        shares: bool = True,
    ) -> None:  # fmt: skip
        super().__init__(self.read_spread)
        self._absolute = Quantity(dimension, least=least)
        self._half = Quantity(DIFFERENCE if dimension is TEMPERATURE else dimension, least=0.0)
        self._share = Quantity(PERCENT, least=0.0)
        self._example, self._own = dimension.example, own
        self._shares = shares and dimension is not PERCENT

    def read_spread(self, value: Any) -> Spread:
        """Read a distribution from a file's value."""
        if isinstance(value, tuple | list):
            if not value:
                raise refuse("there is nothing to choose from", f"Write [{self._example}, …]")
            shown = f"[{', '.join(tidy(each) for each in value)}]"
            return Spread("one_of", tuple(map(self._absolute.read_one, value)), False, shown)
        around = _AROUND.fullmatch(value.strip()) if isinstance(value, str) else None
        if around is not None:
            return self._read_around(value, "normal" if around[1] == "normal" else "within", around)
        low, dots, high = value.partition("..") if isinstance(value, str) else (value, "", "")
        if not dots:
            return Spread("one_of", (self._absolute.read_one(value),), False, tidy(value))
        ends = self._absolute.read_one(low.strip()), self._absolute.read_one(high.strip())
        if ends[0] > ends[1]:
            raise refuse(f"{value!r} ends below its start", "Write the lower end first")
        return Spread("between", ends, False, tidy(value))

    def _read_around(
        self, value: str, how: Literal["within", "normal"], around: re.Match[str]
    ) -> Spread:
        if not self._own:
            raise refuse(
                f"{tidy(value)} is relative, but the spec has no value for it",
                f"Write both ends, such as {self._example} .. {self._example}",
            )
        if self._shares and around[2].strip().endswith("%"):
            share = self._share.read_one(around[2]) / 100
            return Spread(how, (share,), True, tidy(value))
        return Spread(how, (self._half.read_one(around[2]),), False, tidy(value))


ALL = "all"
"""Stands in place of a name, for all parts that are not named."""
LEAST_CAPACITY, LEAST_RESISTANCE = 0.001, 1e-6
"""The lowest values in a spec, J/K and K/W."""

_Chance = Annotated[float, Quantity(PERCENT, least=0.0, most=100.0)]
_At = Annotated[Spread, Spreads(DURATION, least=0.0, own=False)]
_Capacity = Annotated[Spread, Spreads(CAPACITY, least=LEAST_CAPACITY)]
_Resistance = Annotated[Spread, Spreads(THERMAL_RESISTANCE, least=LEAST_RESISTANCE)]
_Error = Annotated[Spread, Spreads(DIFFERENCE)]
_Ambient = Annotated[Spread, Spreads(TEMPERATURE, least=ABSOLUTE_ZERO_C, shares=False)]
_Noise = Annotated[Spread, Spreads(DIFFERENCE, least=0.0)]


class Ask(Model):
    """An operator sets a setpoint, through the spec's interface."""

    loop: Reference = Field(description="Loop whose setpoint is set.")
    at_s: _At = Field(alias="at", description="When.")
    setpoint_c: Annotated[Spread, Spreads(TEMPERATURE, own=False)] = Field(
        alias="setpoint", description="The setpoint; keys set the nearest one of their steps."
    )
    chance_percent: _Chance = Field(100.0, alias="chance", description="Share of the runs with it.")


class Upset(Model):
    """A disturbance of the machine, or a loss of the controller's power."""

    at_s: _At = Field(alias="at", description="When.")
    node: Reference | None = Field(
        None, description="Node whose temperature jumps: a door opens, cold work is put in."
    )
    by_k: Annotated[Spread, Spreads(DIFFERENCE, own=False)] | None = Field(
        None, alias="by", description="How much it jumps, such as -30 K .. -10 K."
    )
    power_cut_s: Annotated[Spread, Spreads(DURATION, least=0.01, own=False)] | None = Field(
        None, alias="power_cut", description="How long the controller has no power."
    )
    chance_percent: _Chance = Field(100.0, alias="chance", description="Share of the runs with it.")

    @model_validator(mode="after")
    def _one_thing(self) -> Upset:
        if (self.node is None) != (self.by_k is None):
            raise refuse("`node` and `by` belong together", "Write {at: …, node: …, by: …}")
        if (self.node is None) == (self.power_cut_s is None):
            raise refuse(
                "an upset is either a jump of a node or a power cut",
                "Write {at: …, node: …, by: …} or {at: …, power_cut: …}",
            )
        return self


class Faults(Model):
    """At most one part of the machine breaks in a run."""

    chance_percent: _Chance = Field(alias="chance", description="Share of the runs with a fault.")
    of: tuple[Reference, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Faults to choose from. Default: all that apply."
    )
    at_s: _At | None = Field(
        None, alias="at", description="When it fails. Default: in the scenario's first six tenths."
    )


class Vary(Model):
    """A file that says what a campaign varies."""

    capacities: Annotated[Mapping[str, _Capacity], ReadOnly] = Field(
        {}, description="Heat capacities of nodes, by name.", validate_default=True
    )
    resistances: Annotated[Mapping[str, _Resistance], ReadOnly] = Field(
        {}, description="Resistances of links, by their ends, as air-walls.", validate_default=True
    )
    ambient_c: _Ambient | None = Field(
        None, alias="ambient", description="Temperature around the machine."
    )
    supply_percent: Annotated[Spread, Spreads(PERCENT, least=0.0)] | None = Field(
        None,
        alias="supply",
        description="Supply voltage of all loads, relative to its nominal value; the heat is "
        "proportional to its square.",
    )
    errors: Annotated[Mapping[str, _Error], ReadOnly] = Field(
        {},
        description="By sensor, its constant error; for a current sensor, a share.",
        validate_default=True,
    )
    noise_k: Annotated[Mapping[str, _Noise], ReadOnly] = Field(
        {}, alias="noise", description="By sensor, standard deviation of its noise.",
        validate_default=True,
    )  # fmt: skip
    late_s: Annotated[Spread, Spreads(DURATION, least=0.0, own=False)] | None = Field(
        None, alias="late", description="Delay of each event of the scenario."
    )
    asks: tuple[Ask, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Setpoints that operators set."
    )
    upsets: tuple[Upset, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Disturbances of the machine."
    )
    faults: Faults | None = Field(None, description="Parts that break.")

    def lines(self) -> Iterator[tuple[str, str]]:
        """Yield each varied quantity and its distribution, in a few words."""
        told: tuple[tuple[str, Mapping[str, Spread]], ...] = (
            ("capacities", self.capacities), ("resistances", self.resistances),
            ("ambient", _alone(self.ambient_c)), ("supply", _alone(self.supply_percent)),
            ("errors", self.errors), ("noise", self.noise_k), ("late", _alone(self.late_s)),
        )  # fmt: skip
        for key, spreads in told:
            if spreads:
                yield (
                    key,
                    ", ".join(f"{name} {each.text}".strip() for name, each in spreads.items()),
                )
        for ask in self.asks:
            what = f"{ask.loop} {ask.setpoint_c.text} at {ask.at_s.text}"
            yield "asks", f"{what}{_in(ask.chance_percent)}"
        for upset in self.upsets:
            by, cut = upset.by_k, upset.power_cut_s
            what = f"{upset.node} {by.text}" if by else f"power cut {cut.text if cut else ''}"
            yield "upsets", f"{what} at {upset.at_s.text}{_in(upset.chance_percent)}"
        if self.faults is not None:
            what = ", ".join(self.faults.of) or "any"
            at = f" at {self.faults.at_s.text}" if self.faults.at_s else ""
            yield "faults", f"{what}{at}{_in(self.faults.chance_percent)}"


def _alone(spread: Spread | None) -> dict[str, Spread]:
    return {} if spread is None else {"": spread}


def _in(chance_percent: float) -> str:
    return "" if chance_percent == 100.0 else f", in {chance_percent:g} % of the runs"


def spread_of(spreads: Mapping[str, Spread], name: str) -> Spread | None:
    """Return the distribution for a name, or that for `all`."""
    return spreads.get(name, spreads.get(ALL))


def vary_of(entries: Mapping[str, Any]) -> Vary:
    """Return a Vary from the entries of its file."""
    return Vary.model_validate(dict(entries))
