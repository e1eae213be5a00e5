"""Thermocouples of any type behind a MAX31856."""

import math
from typing import Annotated, ClassVar, Literal, get_args

from pydantic import Field

from heatwright.spec.base import Least, PinName, WholeNumber
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.sensing.conversion import TICK_S
from heatwright.spec.sensing.thermocouples import Converter
from heatwright.spec.units import FREQUENCY

ThermocoupleType = Literal["B", "E", "J", "K", "N", "R", "S", "T"]

TYPE_CODES = "".join(get_args(ThermocoupleType))
"""The converter's code of a type is the type's place in this list (data sheet, CR1)."""

RANGE_C: dict[str, tuple[float, float]] = {
    "B": (250.0, 1820.0),
    "E": (-200.0, 1000.0),
    "J": (-210.0, 1200.0),
    "K": (-200.0, 1372.0),
    "N": (-200.0, 1300.0),
    "R": (-50.0, 1768.0),
    "S": (-50.0, 1768.0),
    "T": (-200.0, 400.0),
}
"""Range by the thermocouple's type (data sheet, "Thermocouple Voltage Conversion")."""

HIGHEST_C = {kind: high_c for kind, (_, high_c) in RANGE_C.items()} | {
    "K": 1300.0, "R": 1750.0, "S": 1750.0,
}  # fmt: skip
"""Highest setpoint by the thermocouple's type: in the last kelvins of the converter's range some
types age within hours."""

AVERAGES = (1, 2, 4, 8, 16)
OPEN_TEST_S = 0.015
"""Longest time that the test for an open thermocouple adds to a conversion, with less than 5 kΩ in
its wires (data sheet, "Open-Circuit Fault Detection")."""
READ_TICKS = 7
"""Maximum number of ticks in which the firmware reads and checks all registers."""
SET_UP_TICKS = 9
"""Maximum number of ticks in which it sets up the chip, and detects the first conversion's end."""


class _Samples(WholeNumber):
    """Marks the number of samples the chip averages: a power of two."""

    def __init__(self) -> None:
        super().__init__("a number of samples", 1, 16, 2)
        self.json_schema = {"enum": list(AVERAGES)}
        self.read = self._read

    def _read(self, value: object) -> int:
        found = self.read_number(value)
        if found not in AVERAGES:
            raise refuse(f"the chip cannot average {found} samples", "Use 1, 2, 4, 8 or 16")
        return found


class Max31856(Converter):
    """A thermocouple behind a MAX31856, on any four pins."""

    kind: Literal["max31856"]
    data_in: PinName = Field(description="Pin at the converter's data input, SDI.")
    data_out: PinName = Field(description="Pin at the converter's data output, SDO.")
    thermocouple: ThermocoupleType = Field("K", description="Type of the thermocouple.")
    selectable: tuple[ThermocoupleType, ...] = Field(
        (), max_length=8, description="Types that the operator may choose; kept in EEPROM."
    )
    mains_filter_hz: Annotated[float, Quantity(FREQUENCY, choices=(50.0, 60.0))] = Field(
        50.0, alias="mains_filter", description="Mains frequency that the chip filters out."
    )
    average: Annotated[int, _Samples()] = Field(
        1, description="Samples that the chip averages: 1, 2, 4, 8 or 16."
    )
    least: ClassVar[Least] = Least(630, 30)
    rules: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5, 17, 18)
    reading_bits: ClassVar[int] = 32
    step_k: ClassVar[float] = 2.0**-7  # 19 bits
    clips_c: ClassVar[tuple[float, float] | None] = None

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature that its thermocouple measures, °C (data sheet)."""
        return RANGE_C[self.thermocouple]

    @property
    def highest_c(self) -> float:
        """Highest setpoint with its thermocouple, °C."""
        return HIGHEST_C[self.thermocouple]

    def error_k(self, temperature_c: float) -> float:
        """Largest error, K: 0.15 % of the type's span, and 0.7 K of the cold junction."""
        del temperature_c
        low_c, high_c = self.range_c
        return 0.7 + 0.0015 * (high_c - low_c)

    @property
    def conversion_s(self) -> float:
        """Longest time of a conversion after the first, s (data sheet, automatic conversion)."""
        slow = self.mains_filter_hz == 50.0
        return (0.11 if slow else 0.09) + (self.average - 1) * (0.02 if slow else 0.01667)

    @property
    def free_running_s(self) -> float:
        """Interval of its conversions, which it starts by itself, one after the other, s."""
        return self.conversion_s

    @property
    def read_s(self) -> float:
        """Time of one more conversion, which is not synchronous with the loop, and of a reading, s.

        One conversion of 16 takes longer: it tests for an open thermocouple. READ_TICKS is enough
        on the slowest pins.
        """
        return self.conversion_s + OPEN_TEST_S + READ_TICKS * TICK_S

    @property
    def first_conversion_s(self) -> float:
        """Longest time of the first conversion after the chip was set up, s (data sheet)."""
        slow = self.mains_filter_hz == 50.0
        return (0.185 if slow else 0.155) + (self.average - 1) * (0.04 if slow else 0.03333)

    @property
    def first_s(self) -> float:
        """Time from the power-up to the first reading, s: set-up, conversion and reading."""
        return self.first_conversion_s + (SET_UP_TICKS + READ_TICKS) * TICK_S


def variants(sensor: object) -> dict[str, Max31856]:
    """Return the sensor with each selectable type of thermocouple; empty if there is none."""
    if not isinstance(sensor, Max31856):
        return {}
    return {kind: sensor.model_copy(update={"thermocouple": kind}) for kind in sensor.selectable}


def lowered(sensor: object, setpoint_c: float, maximum_c: float) -> dict[str, float]:
    """Return each selectable type's highest setpoint, °C, if it is below the loop's highest.

    It is rounded down to a tenth of a degree. setpoint_c -- the loop's highest setpoint, °C;
    maximum_c -- the loop's `protection.maximum`, °C, which stays as far above the setpoint.
    """
    found = {}
    for kind, chosen in variants(sensor).items():
        high_c = chosen.range_c[1]
        reaches_c = high_c - chosen.error_k(high_c) - (maximum_c - setpoint_c)
        highest_c = math.floor(10 * min(chosen.highest_c, reaches_c) + 1e-6) / 10
        if highest_c < setpoint_c:
            found[kind] = highest_c
    return found
