"""Quantities: text with a unit on one side, a number in the base unit on the other.

Base units are s, °C, K, W, Ω, V, A, Hz, % (0..100) and bit, and J/K, K/W, K/s, m², W/m²K.
A conversion is decimal and rounded once, so `20 ms` is exactly the float 0.02.
"""

from __future__ import annotations

import math
import re
import unicodedata
from decimal import Decimal
from typing import Any, NamedTuple

from pydantic_core import core_schema

from heatwright.spec.problems import refuse

LONGEST = 64
"""Characters in a quantity. Longer text is a mistake, and quoting it would bury the message."""

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_QUANTITY = re.compile(rf"({NUMBER})\s*(.*)", re.ASCII | re.DOTALL)
_PREFIXES = {"M": "1e6", "k": "1e3", "": "1", "c": "1e-2", "m": "1e-3", "μ": "1e-6"}
_DROPPED = str.maketrans("", "", "·*()")


class Unit(NamedTuple):
    """One unit of a dimension: base = (number − offset) · factor."""

    factor: Decimal
    offset: Decimal = Decimal(0)


class Dimension(NamedTuple):
    """A kind of quantity: its name and example in messages, its units by spelling."""

    name: str
    base: str
    example: str
    shown: str
    """The units as the messages list them."""
    units: dict[str, Unit]


def _prefixed(unit: str, prefixes: str = "", *others: str) -> dict[str, Unit]:
    """Give a unit and its other spellings their prefixes, such as "k m μ"."""
    return {
        prefix + name: Unit(Decimal(_PREFIXES[prefix]))
        for prefix in ("", *prefixes.split())
        for name in (unit, *others)
    }


def _fraction(numerator: str, denominator: int) -> Unit:
    return Unit(Decimal(numerator) / Decimal(denominator))


_CELSIUS = Unit(Decimal(1))
_KELVIN = Unit(Decimal(1), Decimal("273.15"))
_FAHRENHEIT = Unit(Decimal(5) / Decimal(9), Decimal(32))

TEMPERATURE = Dimension(
    "temperature",
    "°C",
    "50 °C",
    "°C, °F or K",
    {"°C": _CELSIUS, "C": _CELSIUS, "°F": _FAHRENHEIT, "F": _FAHRENHEIT, "K": _KELVIN},
)
DIFFERENCE = Dimension("temperature difference", "K", "2 K", "K", _prefixed("K", "m"))
DURATION = Dimension(
    "duration",
    "s",
    "1 s",
    "ms, s, min, h or d",
    _prefixed("s", "m μ")
    | {"min": Unit(Decimal(60)), "h": Unit(Decimal(3600)), "d": Unit(Decimal(86400))},
)
POWER = Dimension("power", "W", "240 W", "W or kW", _prefixed("W", "m k"))
FREQUENCY = Dimension("frequency", "Hz", "1 kHz", "Hz, kHz or MHz", _prefixed("Hz", "k M"))
RATE = Dimension(
    "rate of temperature",
    "K/s",
    "5 K/s",
    "K/s or K/min",
    _prefixed("K/s") | {"K/min": _fraction("1", 60)},
)
PERCENT = Dimension("percentage", "%", "80 %", "%", _prefixed("%"))
BITS = Dimension("number of bits", "bit", "12 bit", "bit", _prefixed("bit"))
CAPACITY = Dimension("heat capacity", "J/K", "900 J/K", "J/K or kJ/K", _prefixed("J/K", "k"))
THERMAL_RESISTANCE = Dimension(
    "thermal resistance", "K/W", "0.17 K/W", "K/W or mK/W", _prefixed("K/W", "m")
)
RESISTANCE = Dimension(
    "resistance", "Ω", "4.7 kΩ", "Ω, kΩ or MΩ", _prefixed("Ω", "m k M", "ohm", "Ohm")
)
VOLTAGE = Dimension("voltage", "V", "24 V", "V or mV", _prefixed("V", "m"))
CURRENT = Dimension("current", "A", "3 A", "A or mA", _prefixed("A", "m"))
AREA = Dimension(
    "area", "m²", "0.5 m²", "m² or cm²", _prefixed("m2") | {"cm2": Unit(Decimal("1e-4"))}
)
FILM = Dimension("heat transfer coefficient", "W/m²K", "8.7 W/m²K", "W/m²K", _prefixed("W/m2K"))


def number(value: float) -> str:
    """Write a number for a message: six digits, and no exponent below a thousand million."""
    return f"{value:.0f}" if 1e6 <= abs(value) < 1e9 else f"{value:.6g}"


def _spelling(unit: str) -> str:
    """Bring a unit, already in NFKC, to the spelling of the tables: no blanks, `m2`, `μ`."""
    plain = "".join(unit.split()).translate(_DROPPED)
    return "μ" + plain[1:] if plain in {"us", "uV", "uA"} else plain


def parse(text: object, dimension: Dimension) -> float:
    """Read one quantity; the result is in the base unit and finite.

    Raises PydanticCustomError with reason and remedy.
    """
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise refuse(f"a {dimension.name} is needed here", f"Write one, such as {dimension.example}")
    if not isinstance(text, str):
        raise _no_unit(str(text), dimension)
    if len(text) > LONGEST:
        raise refuse(
            f"this text is too long for a {dimension.name}", f"Write one, such as {dimension.example}"
        )
    plain = unicodedata.normalize("NFKC", text).replace("−", "-").strip()
    match = _QUANTITY.fullmatch(plain)
    if match is None:
        raise refuse(f"{text!r} is not a {dimension.name}", f"Write one, such as {dimension.example}")
    unit = dimension.units.get(_spelling(match[2]))
    if unit is None:
        raise _wrong_unit(text, match[1], _spelling(match[2]), dimension)
    value = float((Decimal(match[1]) - unit.offset) * unit.factor)
    if not math.isfinite(value):
        raise refuse(f"{text!r} is too large", f"Write a {dimension.name} such as {dimension.example}")
    return value + 0.0  # −0.0 becomes 0.0: one value has one spelling in the generated C


def _no_unit(text: str, dimension: Dimension) -> Exception:
    return refuse(
        f"{text} has no unit, and a {dimension.name} is needed",
        f"Write the unit ({dimension.shown}), as in {dimension.example}",
    )


def _wrong_unit(text: str, digits: str, unit: str, dimension: Dimension) -> Exception:
    if not unit:
        return _no_unit(text, dimension)
    if unit.startswith(","):
        return refuse(f"{text!r} has a decimal comma", "Write a decimal point")
    if dimension is DIFFERENCE and unit in TEMPERATURE.units:
        kelvin = f", as in {digits} K" if TEMPERATURE.units[unit] is _CELSIUS else ""
        return refuse(
            f"{text!r} is a temperature, and a difference of two temperatures is needed",
            f"Write the difference in K{kelvin}",
        )
    return refuse(
        f"{text!r} does not have the unit of a {dimension.name}",
        f"Use {dimension.shown}, as in {dimension.example}",
    )


class Quantity:
    """Marks a model's float field: `Annotated[float, Quantity(DURATION, above=0)]`."""

    def __init__(
        self,
        dimension: Dimension,
        *,
        least: float = -math.inf,
        most: float = math.inf,
        above: float = -math.inf,
    ) -> None:
        """Limit the quantity to least..most, and to more than `above`."""
        self.dimension = dimension
        self.least = least
        self.most = most
        self.above = above

    def read(self, value: object) -> float:
        """Read one quantity and hold it to its limits."""
        result = parse(value, self.dimension)
        base = self.dimension.base
        if result < self.least:
            raise refuse(f"{value} is too small", f"Use at least {number(self.least)} {base}")
        if result <= self.above:
            raise refuse(f"{value} is too small", f"Use more than {number(self.above)} {base}")
        if result > self.most:
            raise refuse(f"{value} is too large", f"Use at most {number(self.most)} {base}")
        return result

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)


class QuantityRange(Quantity):
    """Marks a field of two floats, lowest and highest: `48.5 °C .. 51.9 °C`."""

    def read_range(self, value: object) -> tuple[float, float]:
        """Read both ends and put them in order."""
        low, dots, high = value.partition("..") if isinstance(value, str) else ("", "", "")
        if not dots:
            example = self.dimension.example
            raise refuse(
                f"a range of a {self.dimension.name} is needed here",
                f"Write its two ends, such as {example} .. {example}",
            )
        ends = self.read(low.strip()), self.read(high.strip())
        if ends[0] > ends[1]:
            raise refuse(f"{value!r} ends below its start", "Write the lower end first")
        return ends

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read_range)
