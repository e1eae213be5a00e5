"""Distributions of quantities: `± 20 %`, `normal 5 %`, `10 °C .. 30 °C`, `[1 K, 2 K]`."""

import re
from typing import Any, Literal, NamedTuple

from numpy.random import Generator

from heatwright.spec.problems import Checked, refuse
from heatwright.spec.quantity import Quantity, tidy
from heatwright.spec.units import DIFFERENCE, PERCENT, TEMPERATURE, Dimension

SIGMAS = 3.0
"""A normal quantity beyond this many standard deviations is drawn again: no such part is sold."""

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
