"""Dimensions and units: the units that a number may have, and their conversion to the base unit."""

from decimal import Decimal
from typing import NamedTuple

_PREFIXES = {"M": "1e6", "k": "1e3", "": "1", "c": "1e-2", "m": "1e-3", "μ": "1e-6"}


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
    largest: float
    """Largest value, in the base unit: no thermal machine has more, so more is a typing error."""
    units: dict[str, Unit]


def _prefixed(unit: str, prefixes: str = "", *others: str) -> dict[str, Unit]:
    """Return a unit and its other spellings, each also with the prefixes, such as "k m μ"."""
    return {
        prefix + name: Unit(Decimal(_PREFIXES[prefix]))
        for prefix in ("", *prefixes.split())
        for name in (unit, *others)
    }


_CELSIUS = Unit(Decimal(1))
_KELVIN = Unit(Decimal(1), Decimal("273.15"))
_FAHRENHEIT = Unit(Decimal(5) / Decimal(9), Decimal(32))

TEMPERATURE = Dimension(
    "temperature",
    "°C",
    "50 °C",
    "°C, °F or K",
    5000.0,
    {"°C": _CELSIUS, "C": _CELSIUS, "°F": _FAHRENHEIT, "F": _FAHRENHEIT, "K": _KELVIN},
)
DIFFERENCE = Dimension("temperature difference", "K", "2 K", "K", 5000.0, _prefixed("K", "m"))
DURATION = Dimension(
    "duration",
    "s",
    "1 s",
    "ms, s, min, h or d",
    1e8,
    _prefixed("s", "m μ")
    | {"min": Unit(Decimal(60)), "h": Unit(Decimal(3600)), "d": Unit(Decimal(86400))},
)
POWER = Dimension("power", "W", "240 W", "W or kW", 1e6, _prefixed("W", "m k"))
FREQUENCY = Dimension("frequency", "Hz", "1 kHz", "Hz, kHz or MHz", 1e8, _prefixed("Hz", "k M"))
RATE = Dimension(
    "rate of temperature",
    "K/s",
    "5 K/s",
    "K/s or K/min",
    1e4,
    _prefixed("K/s") | {"K/min": Unit(Decimal(1) / Decimal(60))},
)
PROGRAM_RATE = Dimension(
    "rate of a program",
    "K/h",
    "150 K/h",
    "K/h or K/min",
    1e5,
    _prefixed("K/h") | {"K/min": Unit(Decimal(60))},
)
PERCENT = Dimension("percentage", "%", "80 %", "%", 1e3, _prefixed("%"))
BITS = Dimension("number of bits", "bit", "12 bit", "bit", 64.0, _prefixed("bit", "", "bits"))
CAPACITY = Dimension("heat capacity", "J/K", "900 J/K", "J/K or kJ/K", 1e9, _prefixed("J/K", "k"))
THERMAL_RESISTANCE = Dimension(
    "thermal resistance", "K/W", "0.17 K/W", "K/W or mK/W", 1e6, _prefixed("K/W", "m")
)
RESISTANCE = Dimension(
    "resistance", "Ω", "4.7 kΩ", "Ω, kΩ or MΩ", 1e9, _prefixed("Ω", "m k M", "ohm", "Ohm")
)
VOLTAGE = Dimension("voltage", "V", "24 V", "V or mV", 1e5, _prefixed("V", "m"))
CURRENT = Dimension("current", "A", "3 A", "A or mA", 1e5, _prefixed("A", "m"))
AREA = Dimension(
    "surface", "m²", "0.5 m²", "m² or cm²", 1e6, _prefixed("m2") | {"cm2": Unit(Decimal("1e-4"))}
)
FILM = Dimension(
    "heat transfer coefficient", "W/m²K", "8.7 W/m²K", "W/m²K", 1e6, _prefixed("W/m2K")
)
COEFFICIENT = Dimension(
    "temperature coefficient",
    "ppm/K",
    "3925 ppm/K",
    "ppm/K or %/K",
    1e6,
    {"ppm/K": Unit(Decimal(1)), "%/K": Unit(Decimal(10_000))},
)
CONDUCTIVITY = Dimension(
    "thermal conductivity", "W/(m·K)", "0.2 W/(m·K)", "W/(m·K)", 1e4, _prefixed("W/mK", "m")
)
SURFACE_LOAD = Dimension(
    "surface load",
    "W/cm²",
    "2 W/cm²",
    "W/cm² or W/m²",
    1e4,
    _prefixed("W/cm2") | {"W/m2": Unit(Decimal("1e-4"))},
)
RESISTIVITY = Dimension(
    "resistivity", "Ω·mm²/m", "1.1 Ω·mm²/m", "Ω·mm²/m", 1e6, _prefixed("Ωmm2/m", "", "ohmmm2/m")
)
SPIN = Dimension("speed of rotation", "rpm", "1500 rpm", "rpm", 1e6, _prefixed("rpm"))
AIR_SPEED = Dimension("speed of air", "m/s", "2 m/s", "m/s", 1e3, _prefixed("m/s"))
BETA = Dimension("beta value", "K", "3950 K", "K", 2e4, _prefixed("K"))
VOLTAGE_PER_KELVIN = Dimension(
    "voltage for each kelvin", "V/K", "10 mV/K", "mV/K or V/K", 1e3, _prefixed("V/K", "m")
)
VOLTAGE_PER_AMPERE = Dimension(
    "voltage for each ampere", "V/A", "0.2 V/A", "mV/A or V/A", 1e3, _prefixed("V/A", "m")
)
LENGTH = Dimension("length", "mm", "8 mm", "mm", 1e6, _prefixed("mm"))
SPEED = Dimension("speed", "mm/s", "20 mm/s", "mm/s", 1e6, _prefixed("mm/s"))
ACCELERATION = Dimension("rate of speed", "mm/s²", "50 mm/s²", "mm/s²", 1e7, _prefixed("mm/s2"))
FEED_HEAT = Dimension(
    "heat of the filament",
    "J/(K·mm)",
    "0.0056 J/K/mm",
    "J/K/mm",
    1e6,
    _prefixed("J/K/mm", "m", "J/Kmm"),
)
