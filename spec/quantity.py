"""Quantities: conversion between text with a unit and a number in the base unit.

Base units are s, °C, K, W, Ω, V, A, Hz, mm, % (0..100) and bit, and J/K, K/W, K/s, V/K, m², W/m²K,
mm/s, mm/s², J/(K·mm), ppm/K, rpm.
A conversion is decimal and rounded once, so `20 ms` is exactly the float 0.02.
"""

import math
import re
import unicodedata
from decimal import Decimal

from heatwright.spec.loading.suggest import listed
from heatwright.spec.problems import Checked, refuse, shown
from heatwright.spec.units import DIFFERENCE, DURATION, FREQUENCY, TEMPERATURE, Dimension

LONGEST = 64
"""Maximum length of a quantity. Longer text is a mistake; quoting it would bury the message."""

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,2})?"
"""The exponent has two digits: enough for thermal machines, and no result can overflow."""
_QUANTITY = re.compile(rf"({NUMBER})\s*(.*)", re.ASCII | re.DOTALL)
_DROPPED = str.maketrans("", "", "·*()")


def number(value: float) -> str:
    """Write a number for a message: six digits, and no exponent below a thousand million."""
    return f"{value:.0f}" if 1e6 <= abs(value) < 1e9 else f"{value:.6g}"


def about(value: float) -> str:
    """Write a computed number for a message: three digits."""
    return number(float(f"{value:.3g}"))


def rounded_up(value: float) -> str:
    """Write a computed lower limit for a message: three digits, rounded up."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return about(math.ceil(value / step) * step)


def rounded_down(value: float) -> str:
    """Write a computed upper limit for a message: three digits, rounded down."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return about(math.floor(value / step) * step)


def duration(seconds: float) -> str:
    """Write a duration for a message: `750 ms`, `1.5 s`, `10 min`."""
    if 0 < seconds < 1:
        return f"{number(seconds * 1000)} ms"
    for unit, size in (("h", 3600), ("min", 60)):
        if seconds >= size and seconds % size == 0:
            return f"{number(seconds / size)} {unit}"
    return f"{number(seconds)} s"


def hertz(frequency_hz: float) -> str:
    """Write a frequency for a message, in four digits: `976.6 Hz`, `16 MHz`."""
    for unit, size in (("MHz", 1e6), ("kHz", 1e3)):
        if frequency_hz >= size:
            return f"{frequency_hz / size:.4g} {unit}"
    return f"{frequency_hz:.4g} Hz"


def celsius(temperature_c: float) -> str:
    """Write a temperature for a message."""
    return f"{number(temperature_c)} °C"


def amount(value: float, dimension: Dimension) -> str:
    """Write a value in the base unit for a message."""
    if dimension is DURATION:
        return duration(value)
    return hertz(value) if dimension is FREQUENCY else f"{number(value)} {dimension.base}"


def tidy(text: object) -> str:
    """Write a quantity of the file for a message: on one line, with plain blanks."""
    return " ".join(str(text).split())


def _spelling(unit: str) -> str:
    """Bring a unit to the spelling of the tables: no blanks, `m2`, `μ`.

    Only a unit may be respelt so: in a number NFKC would make 103 of 10³.
    """
    plain = "".join(unicodedata.normalize("NFKC", unit).split()).translate(_DROPPED)
    return "μ" + plain[1:] if plain in {"us", "uV", "uA"} else plain


def parse(text: object, dimension: Dimension) -> float:
    """Read one quantity; the result is in the base unit and finite.

    Raises PydanticCustomError: it is refused, with reason and remedy.
    """
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise refuse(
            f"a {dimension.name} is needed here", f"Write, for example, {dimension.example}"
        )
    if not isinstance(text, str):
        raise _no_unit(str(text), dimension)
    if len(text) > LONGEST:
        raise refuse(
            f"this text is too long for a {dimension.name}",
            f"Write, for example, {dimension.example}",
        )
    match = _QUANTITY.fullmatch(text.replace("−", "-").strip())
    if match is None:
        raise _no_number(text, text.strip(), dimension)
    unit = dimension.units.get(_spelling(match[2]))
    if unit is None and _begins_odd(match[2]):
        raise _no_number(text, match[2], dimension)
    if unit is None:
        raise _wrong_unit(text, match[1], _spelling(match[2]), dimension)
    value = float((Decimal(match[1]) - unit.offset) * unit.factor)
    return value + 0.0  # −0.0 becomes 0.0: one value has one spelling in the generated C


def _begins_odd(text: str) -> bool:
    """Return whether a text begins with a digit other than 0 to 9, such as ³, ½ or １."""
    first = text.strip()[:1]
    return first != "" and not first.isascii() and first.isnumeric()


def _no_number(text: str, rest: str, dimension: Dimension) -> Exception:
    if _begins_odd(rest):
        return refuse(
            f"{text!r} has {rest.strip()[0]!r} in its number",
            f"Write the number with the digits 0 to 9, as in {dimension.example}",
        )
    return refuse(f"{text!r} is not a {dimension.name}", f"Write, for example, {dimension.example}")


def _no_unit(text: str, dimension: Dimension) -> Exception:
    return refuse(
        f"{tidy(text)} has no unit, and a {dimension.name} is needed",
        f"Write the unit ({dimension.shown}), as in {dimension.example}",
    )


def _wrong_unit(text: str, digits: str, unit: str, dimension: Dimension) -> Exception:
    if not unit:
        return _no_unit(text, dimension)
    if unit.startswith(","):
        return refuse(f"{text!r} has a decimal comma", "Write a decimal point")
    if dimension is DIFFERENCE and unit in TEMPERATURE.units:
        kelvin = f", as in {digits} K" if unit.endswith("C") else ""
        return refuse(
            f"{text!r} is a temperature, and a difference of two temperatures is needed",
            f"Write the difference in K{kelvin}",
        )
    return refuse(
        f"{text!r} does not have the unit of a {dimension.name}",
        f"Use {dimension.shown}, as in {dimension.example}",
    )


class Quantity(Checked):
    """Marks a model's number field: `Annotated[float, Quantity(DURATION, least=0)]`."""

    def __init__(
        self,
        dimension: Dimension,
        *,
        least: float | None = None,
        most: float | None = None,
        choices: tuple[float, ...] = (),
        words: tuple[str, ...] = (),
    ) -> None:
        """Limit it to least..most, to the range of its dimension, or to a few choices.

        words -- words that may stand in its place, and are returned as they are.
        """
        super().__init__(self.read_one)
        self.dimension = dimension
        self.least = -dimension.largest if least is None else least
        self.most = dimension.largest if most is None else most
        self.choices = choices
        self.words = words
        if words:
            self.read = self.read_word_or_one

    def read_word_or_one(self, value: object) -> object:
        """Read one of the words, or a quantity."""
        if value in self.words:
            return value
        if isinstance(value, str) and not value.strip()[:1].isdigit():
            able = listed([*self.words, f"a {self.dimension.name}"])
            raise refuse(f"{shown(value)} is not possible", f"Use {able}")
        return self.read_one(value)

    def read_one(self, value: object) -> float:
        """Read one quantity and check its limits."""
        result = parse(value, self.dimension)
        if self.choices:
            if result not in self.choices:
                able = [amount(choice, self.dimension) for choice in self.choices]
                raise refuse(f"{tidy(value)} is not possible", f"Use {listed(able)}")
            return self.choices[self.choices.index(result)]
        if result < self.least:
            remedy = f"Use at least {amount(self.least, self.dimension)}"
            raise refuse(f"{tidy(value)} is too small", remedy)
        if result > self.most:
            remedy = f"Use at most {amount(self.most, self.dimension)}"
            raise refuse(f"{tidy(value)} is too large", remedy)
        return result


class QuantityRange(Quantity):
    """Marks a field of two floats, lowest and highest: `48.5 °C .. 51.9 °C`."""

    def __init__(self, dimension: Dimension, *, least: float | None = None) -> None:
        """Read two ends of one dimension."""
        super().__init__(dimension, least=least)
        self.read = self.read_range

    def read_range(self, value: object) -> tuple[float, float]:
        """Read both ends and put them in order."""
        low, dots, high = value.partition("..") if isinstance(value, str) else ("", "", "")
        if not dots:
            example = self.dimension.example
            raise refuse(
                f"a range of a {self.dimension.name} is needed here",
                f"Write its two ends, such as {example} .. {example}",
            )
        ends = self.read_one(low.strip()), self.read_one(high.strip())
        if ends[0] > ends[1]:
            raise refuse(f"{value!r} ends below its start", "Write the lower end first")
        return ends
