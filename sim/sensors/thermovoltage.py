"""Voltages of thermocouples, and their conversion to temperatures.

The functions are NIST's of ITS-90 (Monograph 175), for all eight types.
"""

from functools import cache, lru_cache
from typing import Literal

from thermocouple_its90 import Thermocouple, get

Type = Literal["B", "E", "J", "K", "N", "R", "S", "T"]


@cache
def _wire(letter: Type) -> Thermocouple:
    return get(letter)


def millivolts(letter: Type, tip_c: float, junction_c: float) -> float:
    """Return a thermocouple's voltage for its tip and its cold junction, mV.

    Beyond the ends of NIST's function the voltage is extrapolated linearly, so it is not constant.
    """
    return _emf(letter, tip_c) - _at_junction(letter, junction_c)


def celsius(letter: Type, measured_mv: float, junction_c: float) -> float:
    """Return the tip's temperature for a voltage, °C.

    Beyond the range in which a voltage has only one temperature (type B: from 250 °C) it is
    extrapolated linearly.
    """
    wire = _wire(letter)
    emf_mv = measured_mv + _at_junction(letter, junction_c)
    near_mv = min(max(emf_mv, wire.invertible_emf_range[0]), wire.invertible_emf_range[1])
    near_c = wire.temperature(near_mv)
    beyond_mv = emf_mv - near_mv
    return near_c + (beyond_mv / _slope(letter, near_c) if beyond_mv else 0.0)


def _emf(letter: Type, temperature_c: float) -> float:
    wire = _wire(letter)
    near_c = min(max(temperature_c, wire.range[0]), wire.range[1])
    beyond_k = temperature_c - near_c
    return wire.emf(near_c) + (beyond_k * _slope(letter, near_c) if beyond_k else 0.0)


@lru_cache(maxsize=64)
def _at_junction(letter: Type, junction_c: float) -> float:
    """Return the voltage of a cold junction, mV, cached because it rarely changes."""
    return _emf(letter, junction_c)


@cache
def _slope(letter: Type, temperature_c: float) -> float:
    """Return the voltage's derivative, mV/K, within NIST's function."""
    wire = _wire(letter)
    low_c, high_c = max(temperature_c - 1, wire.range[0]), min(temperature_c + 1, wire.range[1])
    return (wire.emf(high_c) - wire.emf(low_c)) / (high_c - low_c)
