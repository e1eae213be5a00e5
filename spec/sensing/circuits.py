"""The exact conversion of a temperature to a share of the ADC's reference, and back.

Resistor dividers and amplifiers of sensing elements, and the ends of their voltages: a reading
there means an open or a shorted element.
"""

from dataclasses import dataclass
from typing import Any, Protocol

from heatwright.spec.sensing.curves import (
    Beta,
    Coded,
    Curve,
    LinearPlatinum,
    Platinum,
    Points,
    SteinhartHart,
)

SUPPLY_V = 5.0
"""Supply of the boards, and reference of the ADC where the supply is its reference."""

INTERNAL_V = {"atmega328p": 1.1}
"""The chips' internal reference, where it is not 2.56 V (data sheets, ADMUX: REFS)."""
USUAL_INTERNAL_V = 2.56

ZERO_OHM = {"pt100": 100.0, "pt1000": 1000.0}
"""Resistance of each platinum element at 0 °C."""


class Circuit(Protocol):
    """The circuit between the temperature and the pin."""

    @property
    def lowest(self) -> float:
        """The lowest voltage of the circuit, as a share of the reference, 0..1."""

    @property
    def highest(self) -> float:
        """The highest voltage of the circuit, as a share of the reference, 0..1."""

    @property
    def open_is_high(self) -> bool:
        """Whether a broken wire reads at the upper end."""

    def ratio(self, celsius: float) -> float:
        """Share of the reference at a temperature; not limited to what the circuit can give."""

    def celsius(self, ratio: float) -> float:
        """Temperature at a share of the reference between `lowest` and `highest`."""


@dataclass(frozen=True)
class Divider:
    """An element and a resistor between the supply and ground; the pin is where they meet.

    supply -- the divider's supply as a multiple of the reference; pulled_up -- whether the
    resistor is the upper one.
    """

    curve: Curve
    resistor_ohm: float
    pulled_up: bool
    supply: float

    lowest = 0.0

    @property
    def highest(self) -> float:
        """The supply, or as much of it as the reference shows."""
        return min(1.0, self.supply)

    @property
    def open_is_high(self) -> bool:
        """An open element leaves the pin to the resistor."""
        return self.pulled_up

    def ratio(self, celsius: float) -> float:
        """Share of the reference at a temperature."""
        ohm = self.curve.ohm(celsius)
        lower_ohm = ohm if self.pulled_up else self.resistor_ohm
        return self.supply * lower_ohm / (ohm + self.resistor_ohm)

    def celsius(self, ratio: float) -> float:
        """Temperature at a share of the reference."""
        share = ratio / self.supply
        upper, lower = 1 - share, share
        over = lower / upper if self.pulled_up else upper / lower
        return self.curve.celsius(self.resistor_ohm * over)


@dataclass(frozen=True)
class Amplified:
    """A differential amplifier: the voltage of the element above that of R₀, both fed alike.

    With a constant current of excitation / series V = gain · excitation · (R − R₀) / series; with
    plain resistors V = gain · excitation · (R / (R + series) − R₀ / (R₀ + series)). The amplifier
    runs from the excitation's supply and saturates there, and at ground. An open element drives it
    up.
    """

    curve: Platinum | LinearPlatinum
    gain: float
    series_ohm: float
    excitation: float
    """Voltage of the excitation, as a multiple of the reference."""
    is_constant: bool
    """Whether the current through element and R₀ is constant."""

    lowest = 0.0
    open_is_high = True

    @property
    def highest(self) -> float:
        """Share at which the amplifier saturates, or of an open element, if that is less."""
        highest = min(1.0, self.excitation)
        if self.is_constant:
            return highest
        return min(highest, self.gain * (self.excitation - self.across(self.curve.zero_ohm)))

    def across(self, ohm: float, series: float = 1.0) -> float:
        """Voltage across a resistor that is fed, as a share of the reference.

        series -- its series resistor as a multiple of its nominal value.
        """
        series_ohm = series * self.series_ohm
        return self.excitation * ohm / (series_ohm if self.is_constant else series_ohm + ohm)

    def ratio(self, celsius: float) -> float:
        """Share of the reference at a temperature."""
        ohm, zero_ohm = self.curve.ohm(celsius), self.curve.zero_ohm
        if self.is_constant:  # one product: the difference of two would cost digits
            return self.gain * self.across(ohm - zero_ohm)
        return self.gain * (self.across(ohm) - self.across(zero_ohm))

    def celsius(self, ratio: float) -> float:
        """Temperature at a share of the reference."""
        across = ratio / self.gain + self.across(self.curve.zero_ohm)
        rest = self.excitation if self.is_constant else self.excitation - across
        return self.curve.celsius(self.series_ohm * across / rest)


@dataclass(frozen=True)
class Linear:
    """A sensor that gives a voltage: V = offset + scale · t."""

    zero: float
    """Share of the reference at 0 °C."""
    per_k: float
    open_is_high: bool

    lowest = 0.0
    highest = 1.0

    def ratio(self, celsius: float) -> float:
        """Share of the reference at a temperature."""
        return self.zero + self.per_k * celsius

    def celsius(self, ratio: float) -> float:
        """Temperature at a share of the reference."""
        return (ratio - self.zero) / self.per_k


def reference_v(sensor: Any, mcu: str) -> float:
    """Return the voltage that is the ADC's full scale for an analog sensor, V."""
    if sensor.reference == "supply":
        return SUPPLY_V
    if sensor.reference == "internal":
        return INTERNAL_V.get(mcu, USUAL_INTERNAL_V)
    return float(sensor.reference)


def of_voltage(sensor: Any, scale: float, mcu: str, *, open_is_high: bool) -> Linear:
    """Return the circuit of a sensor that gives `scale` volts for each unit, on a chip's ADC."""
    full_v = reference_v(sensor, mcu)
    return Linear(sensor.offset_v / full_v, scale / full_v, open_is_high)


def of_thermistor(sensor: Any, mcu: str) -> Divider:
    """Return the circuit of a thermistor on a chip's ADC."""
    full_v = reference_v(sensor, mcu)
    return _divider(_thermistor(sensor, full_v), sensor.divider, full_v)


def of_platinum(sensor: Any, mcu: str) -> Circuit:
    """Return the circuit of a platinum element on a chip's ADC."""
    full_v, platinum = reference_v(sensor, mcu), _platinum(sensor)
    if sensor.divider is not None:
        return _divider(platinum, sensor.divider, full_v)
    amplifier = sensor.amplifier
    supply = amplifier.excitation_v / full_v
    is_constant = amplifier.feed == "constant_current"
    return Amplified(platinum, amplifier.gain, amplifier.series_ohm, supply, is_constant)


def _divider(curve: Curve, divider: Any, full_v: float) -> Divider:
    return Divider(curve, *_resistor(divider), divider_v(divider) / full_v)


def _resistor(divider: Any) -> tuple[float, bool]:
    """Return a divider's resistor, Ω, and whether it is the upper one."""
    pulled_up = divider.pull_up_ohm is not None
    return (divider.pull_up_ohm if pulled_up else divider.pull_down_ohm), pulled_up


def _platinum(sensor: Any) -> Platinum | LinearPlatinum:
    """Return the standard's curve, or the straight line of the sensor's coefficient."""
    zero_ohm = ZERO_OHM[sensor.element]
    if sensor.alpha_ppm_per_k is None:
        return Platinum(zero_ohm)
    return LinearPlatinum(zero_ohm, sensor.alpha_ppm_per_k * 1e-6)


def divider_v(divider: Any) -> float:
    """Return the voltage that feeds a divider, V."""
    return SUPPLY_V if divider.supply_v is None else float(divider.supply_v)


def code_share(code: int, readings: int) -> float:
    """Return the share of the reference for which a sum of readings stands: its step's middle."""
    return (code / readings + 0.5) / 1024


def _thermistor(sensor: Any, full_v: float) -> Curve:
    """Return the thermistor's curve, of the kind that the spec's keys show."""
    curve = sensor.curve
    if hasattr(curve, "codes"):
        over = full_v / divider_v(sensor.divider)
        pairs = [(over * code_share(code, curve.readings), at_c) for code, at_c in curve.codes]
        return Coded(tuple(sorted(pairs)), *_resistor(sensor.divider))
    if hasattr(curve, "beta_k"):
        return Beta(curve.resistance_ohm, curve.at_c, curve.beta_k)
    if hasattr(curve, "points"):
        return Points(tuple(sorted(curve.points)))
    return SteinhartHart(curve.a, curve.b, curve.c)
