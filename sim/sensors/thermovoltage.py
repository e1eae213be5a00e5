"""What thermocouples give, and what a converter makes of it.

The functions are NIST's of ITS-90 (Monograph 175), of all eight types.
"""

from __future__ import annotations

from functools import cache
from typing import Literal

from thermocouple_its90 import Thermocouple, get

Type = Literal["B", "E", "J", "K", "N", "R", "S", "T"]


@cache
def _wire(letter: Type) -> Thermocouple:
    return get(letter)


def millivolts(letter: Type, tip_c: float, junction_c: float) -> float:
    """Return what a thermocouple gives between its tip and its cold junction, mV.

    Where NIST's function has an end it stays there.
    """
    return _emf(letter, tip_c) - _emf(letter, junction_c)


def celsius(letter: Type, measured_mv: float, junction_c: float) -> float:
    """Return the tip's temperature that a voltage stands for, °C.

    Where that type cannot give such a voltage (type B below 250 °C gives none that is its own) it
    is the nearest that it can.
    """
    wire = _wire(letter)
    least_mv, most_mv = wire.invertible_emf_range
    emf_mv = measured_mv + _emf(letter, junction_c)
    return wire.temperature(min(max(emf_mv, least_mv), most_mv))


def _emf(letter: Type, temperature_c: float) -> float:
    wire = _wire(letter)
    least_c, most_c = wire.range
    return wire.emf(min(max(temperature_c, least_c), most_c))
