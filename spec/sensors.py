"""Sensors: one model for each kind.

Other code uses these properties of a model, and never tests its kind:
on_adc, on_one_wire, measures_current -- where it is and what it measures; rules -- the codes of
the rules that its readings can break. Thermometers also have
reading_bits -- bits of the signed number of a reading; clips_c -- lowest and highest
temperature that a reading can show, None if no reading beyond its range is valid; selectable --
types of thermocouple that the operator may choose; fitting -- settings of its own with which it
would fit into a period. Sensors on the ADC also have unit -- of their quantity; shown_range -- the
values that they can show on a chip; circuit -- from a value to the code; gives_voltage -- whether
the sensor itself gives a voltage, and is no element in a circuit.
"""

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from heatwright.spec.base import DEFAULTS, Least, PinName
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.registry import with_brought
from heatwright.spec.sensing.analog_parts import (
    Amplifier,
    AnalogSensor,
    Curve,
    Divider,
    Volt,
    VoltPerKelvin,
)
from heatwright.spec.sensing.averaging import Started
from heatwright.spec.sensing.circuits import Circuit, of_platinum, of_thermistor, of_voltage
from heatwright.spec.sensing.conversion import TICK_S
from heatwright.spec.sensing.currents import CurrentSensor
from heatwright.spec.sensing.max31856 import Max31856
from heatwright.spec.sensing.thermocouples import Max6675, Max31855
from heatwright.spec.sensing.tolerances import (
    RtdTolerances,
    ThermistorTolerances,
    VoltageTolerances,
)
from heatwright.spec.units import BITS, COEFFICIENT


class Ds18b20(Started):
    """Digital thermometer on a 1-Wire line of its own, with its own supply wire."""

    kind: Literal["ds18b20"]
    pin: PinName = Field(description="Data line; it needs a pull-up resistor of 4.7 kΩ.")
    resolution_bits: Annotated[int, Quantity(BITS, choices=(9, 10, 11, 12))] = Field(
        12,
        alias="resolution",
        description="9 to 12 bit: steps of 0.5, 0.25, 0.125 or 0.0625 K; each doubles the time.",
    )
    least: ClassVar[Least] = Least(580, 25)
    on_adc: ClassVar[Literal[False]] = False
    on_one_wire: ClassVar[bool] = True
    measures_current: ClassVar[Literal[False]] = False
    rules: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5)
    reading_bits: ClassVar[int] = 16
    clips_c: ClassVar[tuple[float, float] | None] = (-55.0, 125.0)
    selectable: ClassVar[tuple[str, ...]] = ()

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature that it measures, °C (data sheet)."""
        return -55.0, 125.0

    def error_k(self, temperature_c: float) -> float:
        """Largest error at a temperature, K (data sheet, thermometer error)."""
        if -10.0 <= temperature_c <= 85.0:
            return 0.5
        return 1.0 if -30.0 <= temperature_c <= 100.0 else 2.0

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion, s (data sheet): 93.75 ms at 9 bit to 750 ms at 12 bit."""
        return float(0.09375 * 2 ** (self.resolution_bits - 9))

    @property
    def read_s(self) -> float:
        """Time of the transfers before and after a conversion, s.

        They are settings, command, its end, nine bytes and their check. A tick starts each, and
        each takes less than a tick (the longest has 105 slots of 64 µs, which are 6.7 ms).
        """
        return 0.05

    @property
    def step_k(self) -> float:
        """Smallest difference that the sensor resolves, K."""
        return float(0.5 / 2 ** (self.resolution_bits - 9))

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Step of the readings, K, which is the same at each temperature."""
        del temperature_c, mcu
        return self.step_k

    def fitting(self, period_s: float) -> str:
        """Name the finest resolution that fits into a period, if a coarser one does."""
        for bits in (11, 10, 9):
            if shortest_period_s(self.model_copy(update={"resolution_bits": bits})) <= period_s:
                return f"a resolution of {bits} bit"
        return ""


class Thermistor(AnalogSensor):
    """A thermistor in a voltage divider on a pin of the ADC."""

    kind: Literal["thermistor"]
    tolerances: ThermistorTolerances = Field(
        DEFAULTS, validate_default=True, description="Tolerances of the parts."
    )
    divider: Divider = Field(description="The resistor in series with the thermistor.")
    curve: Curve = Field(description="Its curve: beta, Steinhart-Hart, points, codes.")
    least: ClassVar[Least] = Least(420, 5)
    amplifier: ClassVar[None] = None
    gives_voltage: ClassVar[Literal[False]] = False

    def circuit(self, mcu: str) -> Circuit:
        """Return the circuit between the sensing element and the ADC of a chip."""
        return of_thermistor(self, mcu)


class Rtd(AnalogSensor):
    """A platinum element according to IEC 60751 or linear, in a divider or behind an amplifier."""

    kind: Literal["rtd"]
    tolerances: RtdTolerances = Field(
        DEFAULTS, validate_default=True, description="Tolerances of the parts."
    )
    element: Literal["pt100", "pt1000"] = Field(description="100 Ω or 1000 Ω at 0 °C.")
    alpha_ppm_per_k: Annotated[float, Quantity(COEFFICIENT, least=3500.0, most=4000.0)] | None = (
        Field(None, alias="alpha", description="R = R0 · (1 + alpha · t) instead of IEC 60751.")
    )
    divider: Divider | None = Field(None, description="The resistor in series with the element.")
    amplifier: Amplifier | None = Field(
        None, description="Excitation and amplifier instead of a divider."
    )
    least: ClassVar[Least] = Least(250, 5)
    curve: ClassVar[None] = None
    gives_voltage: ClassVar[Literal[False]] = False

    @model_validator(mode="after")
    def _one_circuit(self) -> "Rtd":
        if (self.divider is None) == (self.amplifier is None):
            raise refuse(
                "an rtd has either a divider or an amplifier", "Keep the one that is built"
            )
        return self

    def circuit(self, mcu: str) -> Circuit:
        """Return the circuit between the sensing element and the ADC of a chip."""
        return of_platinum(self, mcu)


class Analog(AnalogSensor):
    """A sensor that gives a voltage in proportion to the temperature."""

    kind: Literal["analog"]
    tolerances: VoltageTolerances = Field(
        DEFAULTS, validate_default=True, description="Tolerances of sensor and reference."
    )
    scale_v_per_k: VoltPerKelvin = Field(alias="scale", description="Voltage for each kelvin.")
    offset_v: Volt = Field(0.0, alias="offset", description="Voltage at 0 °C.")
    open_reads: Literal["low", "high"] = Field(
        "low", description="What the pin reads when the wire is broken."
    )
    least: ClassVar[Least] = Least(250, 5)
    curve: ClassVar[None] = None
    divider: ClassVar[None] = None
    amplifier: ClassVar[None] = None
    gives_voltage: ClassVar[Literal[True]] = True

    def circuit(self, mcu: str) -> Circuit:
        """Return the circuit between the sensing element and the ADC of a chip."""
        return of_voltage(self, self.scale_v_per_k, mcu, open_is_high=self.open_reads == "high")


Thermometer = Analog | Ds18b20 | Max6675 | Max31855 | Max31856 | Rtd | Thermistor
"""Sensors by which a loop can be controlled."""

AdcThermometer = Analog | Rtd | Thermistor
AdcSensor = AdcThermometer | CurrentSensor
"""Sensors on pins of the ADC."""

Sensor = Annotated[
    Analog | CurrentSensor | Ds18b20 | Max6675 | Max31855 | Max31856 | Rtd | Thermistor,
    Field(discriminator="kind"),
]
if not TYPE_CHECKING:  # mypy knows only heatwright's own kinds
    Sensor = with_brought("sensor", Sensor)


def shortest_period_s(sensor: Thermometer) -> float:
    """Return the shortest period, s: whole ticks for a conversion and its reading."""
    return round(math.ceil(round(sensor.conversion_s / TICK_S, 6)) * TICK_S + sensor.read_s, 2)
