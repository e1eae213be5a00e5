"""The parts of an analog sensor: dividers, amplifiers, references, thermistor curves."""

import math
from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from heatwright.spec.base import ABSOLUTE_ZERO_C, BareNumber, Model, PinName, WholeNumber
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity, QuantityRange
from heatwright.spec.sensing.averaging import Started
from heatwright.spec.sensing.circuits import Circuit
from heatwright.spec.sensing.conversion import CODES, TICK_S, limits
from heatwright.spec.sensing.tolerances import Accuracy
from heatwright.spec.units import BETA, RESISTANCE, TEMPERATURE, VOLTAGE, VOLTAGE_PER_KELVIN

COARSEST_MCU = "atmega2560"
"""The chip with the highest internal reference, 2.56 V: its steps are used if no board is given."""

SLOPE_OVER_K = 0.01
"""Difference of temperatures over which a curve is taken as straight, K."""

LEAST_CHANGE = 1e-12
"""Share of the reference below which a change is lost in double precision."""


def step_at_k(sensor: Any, temperature_c: float, mcu: str = COARSEST_MCU) -> float:
    """Return the size of an ADC step in kelvin at a temperature, from the curve's slope there.

    Outside the sensor's range, where no reading is valid, it is the size at the end of the range.
    """
    chain: Circuit = sensor.circuit(mcu)
    low_c, high_c = sensor.range_c
    middle_c = min(max(temperature_c, low_c), high_c)
    below, above = middle_c - SLOPE_OVER_K / 2, middle_c + SLOPE_OVER_K / 2
    change = abs(chain.ratio(above) - chain.ratio(below))
    return SLOPE_OVER_K / (CODES * max(change, LEAST_CHANGE))


@cache
def largest_step_k(sensor: Any) -> float:
    """Return the size of the largest ADC step in the sensor's range, K."""
    chain: Circuit = sensor.circuit(COARSEST_MCU)
    bounds = limits(sensor, COARSEST_MCU)
    # The ends of the ADC's scale are left out: a curve may have no temperature there.
    last = min(bounds.high + 1, CODES - 1)
    edges = [chain.celsius(code / CODES) for code in range(max(bounds.low, 1), last + 1)]
    return max(abs(high - low) for low, high in pairwise(edges))


Ohm = Annotated[float, Quantity(RESISTANCE, least=0.01)]
_OfCurve = Annotated[float, Quantity(TEMPERATURE, least=-200.0)]
"""A temperature at which an element has a resistance; far enough from absolute zero."""
Volt = Annotated[float, Quantity(VOLTAGE, least=-5.0, most=5.0)]
VoltPerKelvin = Annotated[float, Quantity(VOLTAGE_PER_KELVIN, least=-1.0, most=1.0)]
_Supply = Annotated[float, Quantity(VOLTAGE, least=0.1)]
FullScale = Annotated[
    float | Literal["supply", "internal"],
    Quantity(VOLTAGE, least=1.0, most=5.0, words=("supply", "internal")),
]
"""Reference of the ADC, its full scale. At AREF it is 1 V to the supply (data sheets)."""


class AnalogSensor(Started):
    """Keys and properties of all sensors on pins of the ADC."""

    kind: str
    pin: PinName = Field(description="A pin that leads to the ADC.")
    range_c: Annotated[tuple[float, float], QuantityRange(TEMPERATURE, least=ABSOLUTE_ZERO_C)] = (
        Field(
            alias="range",
            description="Valid temperatures; a reading beyond is open, shorted or out of range.",
        )
    )
    oversample: Annotated[int, WholeNumber("a number of readings", 1, 32, 4)] = Field(
        1, description="Number of readings, one every 10 ms, that are summed up to one."
    )
    reference: FullScale = Field(
        "supply", description="Full scale of the ADC: `supply`, `internal`, or the volts at AREF."
    )
    accuracy: Accuracy | None = Field(
        None, description="Required accuracy; `check` warns where the parts' errors exceed it."
    )
    on_adc: ClassVar[Literal[True]] = True
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[False]] = False
    rules: ClassVar[tuple[int, ...]] = (2, 4, 17, 18)
    reading_bits: ClassVar[int] = 16
    clips_c: ClassVar[tuple[float, float] | None] = None
    selectable: ClassVar[tuple[str, ...]] = ()
    unit: ClassVar[str] = "K"

    def error_k(self, temperature_c: float) -> float:
        """Largest error of divider, ADC and table at a temperature, K: one step of the ADC."""
        return step_at_k(self, temperature_c)

    @property
    def conversion_s(self) -> float:
        """Time over which the readings of one sum are spread, s."""
        return self.oversample * TICK_S

    @property
    def read_s(self) -> float:
        """Time from the last conversion to the reading, s: 0, as both are in the same tick."""
        return 0.0

    @property
    def step_k(self) -> float:
        """Widest step of the ADC within the range, K."""
        return largest_step_k(self)

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Width of a step of a chip's ADC at a temperature, K."""
        return step_at_k(self, temperature_c, mcu)

    def shown_range(self, mcu: str) -> tuple[float, float]:
        """Range that the sensor can show, °C: the spec's `range`, on any chip."""
        del mcu
        return self.range_c

    def fitting(self, period_s: float) -> str:
        """Name the largest number of readings that fit into a period, if one does."""
        most = math.floor(round(period_s / TICK_S, 6))
        return f"oversample at most {most}" if period_s >= TICK_S else ""


class Divider(Model):
    """A resistor that makes a voltage divider with the element."""

    pull_up_ohm: Ohm | None = Field(
        None, alias="pull_up", description="Resistor to the supply; the element goes to ground."
    )
    pull_down_ohm: Ohm | None = Field(
        None, alias="pull_down", description="Resistor to ground; the element goes to the supply."
    )
    supply_v: _Supply | None = Field(
        None, alias="supply", description="The divider's own supply. Default: the board's 5 V."
    )

    @model_validator(mode="after")
    def _one_resistor(self) -> "Divider":
        if (self.pull_up_ohm is None) == (self.pull_down_ohm is None):
            raise refuse(
                "a divider has one resistor beside the element",
                "Write pull_up or pull_down, such as {pull_up: 4.7 kΩ}",
            )
        return self


class Amplifier(Model):
    """A differential amplifier: `gain` times the voltage of the element above that of R₀."""

    gain: Annotated[float, BareNumber(0.0, 1e6, "33.3")] = Field(description="Gain.")
    excitation_v: _Supply = Field(
        alias="excitation", description="Voltage that feeds the element and R₀."
    )
    series_ohm: Ohm = Field(
        alias="series", description="Resistor through which the element is fed."
    )
    feed: Literal["constant_current", "resistors"] = Field(
        "constant_current",
        description="Current through element and R₀: always `excitation` / `series`, or what "
        "plain resistors of `series` let through.",
    )


class BetaCurve(Model):
    """A thermistor's curve by one resistance and a beta: R = R₀ · exp(β · (1/T − 1/T₀))."""

    resistance_ohm: Ohm = Field(alias="resistance", description="Resistance at `at`.")
    at_c: _OfCurve = Field(alias="at", description="Temperature of `resistance`.")
    beta_k: Annotated[float, Quantity(BETA, least=1.0)] = Field(
        alias="beta", description="Beta value; the data sheet names it with two temperatures."
    )


class SteinhartHartCurve(Model):
    """A thermistor by three coefficients: 1/T = a + b · ln R + c · (ln R)³, in K and Ω."""

    a: Annotated[float, BareNumber(-0.1, 0.1, "8.11e-4")] = Field(
        description="First coefficient, 1/K."
    )
    b: Annotated[float, BareNumber(0.0, 0.1, "2.115e-4")] = Field(
        description="Second coefficient, 1/K."
    )
    c: Annotated[float, BareNumber(0.0, 0.1, "7.07e-8", closed=True)] = Field(
        description="Third coefficient, 1/K."
    )


_Point = tuple[_OfCurve, Ohm]


def _monotonic(points: tuple[_Point, ...]) -> tuple[_Point, ...]:
    """Check that the points form a curve: no temperature twice, and resistance monotonic."""
    if len(points) < 2:
        raise refuse("a curve needs two points at least", "Write [[25 °C, 100 kΩ], …]")
    ordered = sorted(points)
    if any(low[0] == high[0] for low, high in pairwise(ordered)):
        raise refuse("a temperature is twice in this curve", "Delete one of its points")
    if not _one_way(ohm for _, ohm in ordered):
        raise refuse(
            "the resistance must only rise, or only fall, with temperature", "Correct the points"
        )
    return points


def _one_way(values: Iterable[float]) -> bool:
    """Return whether values only rise or only fall."""
    return len({(high > low) - (high < low) for low, high in pairwise(values)} | {0}) == 2


class PointsCurve(Model):
    """A thermistor by a table; between points ln R is linear in 1/T."""

    points: Annotated[tuple[_Point, ...], AfterValidator(_monotonic)] = Field(
        description="Pairs of temperature and resistance."
    )


_Sum = Annotated[int, WholeNumber("a code", 0, 65535, 368)]
_Pair = tuple[_Sum, _OfCurve]


def _rising(pairs: tuple[_Pair, ...]) -> tuple[_Pair, ...]:
    """Check that a table of codes forms a curve: each code once, and temperatures monotonic."""
    if len(pairs) < 2:
        raise refuse("a table needs two pairs at least", "Write [[368, 300 °C], …]")
    ordered = sorted(pairs)
    if any(low[0] == high[0] for low, high in pairwise(ordered)):
        raise refuse("a code is twice in this table", "Delete one of its pairs")
    if not _one_way(at_c for _, at_c in ordered):
        raise refuse("the temperature must only rise, or only fall", "Correct the pairs")
    return pairs


class CodesCurve(Model):
    """A thermistor by a table of the ADC's codes; between two pairs the temperature is linear."""

    codes: Annotated[tuple[_Pair, ...], AfterValidator(_rising)] = Field(
        description="Pairs of the ADC's code and the temperature."
    )
    readings: Annotated[int, WholeNumber("a number of readings", 1, 64, 16)] = Field(
        1, description="Readings of 10 bit that are summed up to one of these codes."
    )

    @model_validator(mode="after")
    def _codes_can_be_read(self) -> "CodesCurve":
        most = 1023 * self.readings
        if max(code for code, _ in self.codes) > most:
            several = f"{self.readings} readings of 10 bit are"
            raise refuse(
                f"{several if self.readings > 1 else 'one reading of 10 bit is'} at most {most}",
                "Correct the codes, or write the readings that one of them sums up, "
                "such as readings: 16",
            )
        return self


def _form(value: Any) -> str:
    """Return a curve's form, as its keys show it."""
    if isinstance(value, Model):
        return type(value).__name__
    keys = set(value) if isinstance(value, dict) else set()
    if "points" in keys:
        return "PointsCurve"
    if "codes" in keys:
        return "CodesCurve"
    return "SteinhartHartCurve" if keys & {"a", "b", "c"} else "BetaCurve"


Curve = Annotated[
    Annotated[BetaCurve, Tag("BetaCurve")]
    | Annotated[SteinhartHartCurve, Tag("SteinhartHartCurve")]
    | Annotated[PointsCurve, Tag("PointsCurve")]
    | Annotated[CodesCurve, Tag("CodesCurve")],
    Discriminator(_form),
]
"""A thermistor's curve, in the form that its keys show; `loading/shape.py` finds models by tags."""
