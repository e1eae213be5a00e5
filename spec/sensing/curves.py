"""The exact resistance of a sensing element at a temperature, and the temperature at a resistance.

Temperatures are in °C, resistances in Ω. Each curve is a function and its inverse. The firmware has
no curve: its tables are computed from the curves.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Protocol

KELVIN = 273.15
"""0 °C in K."""

A, B, C = 3.9083e-3, -5.775e-7, -4.183e-12
"""Coefficients of IEC 60751:2008, 4.2, for platinum: 1/°C, 1/°C², 1/°C⁴."""

NEWTON_STEPS = 50


class Curve(Protocol):
    """A sensing element."""

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""


@dataclass(frozen=True)
class Beta:
    """R = R₀ · exp(β · (1/T − 1/T₀)): a thermistor by two numbers (T in K, β in K)."""

    resistance_ohm: float
    at_c: float
    beta_k: float

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""
        inverse = 1 / (celsius + KELVIN) - 1 / (self.at_c + KELVIN)
        return self.resistance_ohm * math.exp(self.beta_k * inverse)

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""
        inverse = math.log(ohm / self.resistance_ohm) / self.beta_k
        return 1 / (1 / (self.at_c + KELVIN) + inverse) - KELVIN


@dataclass(frozen=True)
class SteinhartHart:
    """1/T = a + b · ln R + c · (ln R)³, a thermistor by three numbers (R in Ω, T in K).

    J. S. Steinhart, S. R. Hart, "Calibration curves for thermistors", Deep-Sea Research 15 (1968).
    """

    a: float
    b: float
    c: float

    def ohm(self, celsius: float) -> float:
        """Resistance, by Newton's method: the derivative is at least b for b > 0 and c ≥ 0."""
        wanted = 1 / (celsius + KELVIN)
        log = (wanted - self.a) / self.b
        for _ in range(NEWTON_STEPS):
            error = self.a + self.b * log + self.c * log**3 - wanted
            change = error / (self.b + 3 * self.c * log**2)
            log -= change
            if abs(change) <= 1e-15 * max(1.0, abs(log)):
                break
        return math.exp(log)

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""
        log = math.log(ohm)
        return 1 / (self.a + self.b * log + self.c * log**3) - KELVIN


@dataclass(frozen=True)
class Points:
    """A table of (°C, Ω), temperature ascending; between its points ln R is linear in 1/T.

    So each piece has its own beta. Beyond the table's ends the outermost pieces are extended.
    """

    points: tuple[tuple[float, float], ...]

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""
        place = bisect_right([point[0] for point in self.points], celsius)
        return self._between(place).ohm(celsius)

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""
        sign = 1 if self.points[-1][1] > self.points[0][1] else -1
        place = bisect_right([sign * point[1] for point in self.points], sign * ohm)
        return self._between(place).celsius(ohm)

    def _between(self, place: int) -> Beta:
        """Return the piece that ends at point `place`, or the first or the last one."""
        place = min(max(place, 1), len(self.points) - 1)
        (low_c, low_ohm), (high_c, high_ohm) = self.points[place - 1 : place + 1]
        inverse = 1 / (high_c + KELVIN) - 1 / (low_c + KELVIN)
        return Beta(low_ohm, low_c, math.log(high_ohm / low_ohm) / inverse)


@dataclass(frozen=True)
class Coded:
    """An element by its divider's voltage: (share of the divider's supply, °C), share ascending.

    Between two pairs the temperature is linear in the share, as in a firmware with such a table.
    Beyond the table's ends the outermost pairs are extended as a beta curve.
    """

    pairs: tuple[tuple[float, float], ...]
    resistor_ohm: float
    pulled_up: bool

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""
        sign = 1 if self.pairs[-1][1] > self.pairs[0][1] else -1
        place = bisect_right([sign * at_c for _, at_c in self.pairs], sign * celsius)
        if not 0 < place < len(self.pairs):
            return self._beyond(place).ohm(celsius)
        (low, low_c), (high, high_c) = self.pairs[place - 1 : place + 1]
        return self._shown(low + (high - low) * (celsius - low_c) / (high_c - low_c))

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""
        over = ohm / self.resistor_ohm if self.pulled_up else self.resistor_ohm / ohm
        share = over / (1 + over)
        place = bisect_right([share for share, _ in self.pairs], share)
        if not 0 < place < len(self.pairs):
            return self._beyond(place).celsius(ohm)
        (low, low_c), (high, high_c) = self.pairs[place - 1 : place + 1]
        return low_c + (high_c - low_c) * (share - low) / (high - low)

    def _shown(self, share: float) -> float:
        """Resistance that makes a share."""
        over = share / (1 - share)
        return self.resistor_ohm * (over if self.pulled_up else 1 / over)

    def _beyond(self, place: int) -> Points:
        """Return the two pairs at an end, as points of temperature and resistance."""
        ends = self.pairs[:2] if place == 0 else self.pairs[-2:]
        return Points(tuple(sorted((at_c, self._shown(share)) for share, at_c in ends)))


@dataclass(frozen=True)
class Platinum:
    """A platinum resistance thermometer according to IEC 60751:2008, −200 to 850 °C.

    R = R₀ · (1 + A·t + B·t²) from 0 °C up, and R₀ · (1 + A·t + B·t² + C·(t − 100)·t³) below.
    """

    zero_ohm: float

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""
        ratio = 1 + A * celsius + B * celsius**2
        if celsius < 0:
            ratio += C * (celsius - 100) * celsius**3
        return self.zero_ohm * ratio

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance: the quadratic's root, below 0 °C improved by Newton."""
        ratio = ohm / self.zero_ohm
        root = 2 * (ratio - 1) / (A + math.sqrt(max(0.0, A * A - 4 * B * (1 - ratio))))
        return root if ratio >= 1 else self._improved(root, ratio)

    def _improved(self, celsius: float, ratio: float) -> float:
        for _ in range(NEWTON_STEPS):
            error = self.ohm(celsius) / self.zero_ohm - ratio
            slope = A + 2 * B * celsius + C * (4 * celsius**3 - 300 * celsius**2)
            celsius -= error / slope
            if abs(error) <= 1e-15:
                break
        return celsius


@dataclass(frozen=True)
class LinearPlatinum:
    """R = R₀ · (1 + α · t): a platinum element with one coefficient, α in 1/K."""

    zero_ohm: float
    per_k: float

    def ohm(self, celsius: float) -> float:
        """Resistance at a temperature."""
        return self.zero_ohm * (1 + self.per_k * celsius)

    def celsius(self, ohm: float) -> float:
        """Temperature at a resistance."""
        return (ohm / self.zero_ohm - 1) / self.per_k
