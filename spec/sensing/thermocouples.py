"""Converters of thermocouples, and those of them that a program reads over three wires."""

from typing import ClassVar, Literal

from pydantic import Field

from heatwright.spec.base import Least, PinName
from heatwright.spec.sensing.averaging import Averaged, Started
from heatwright.spec.sensing.conversion import TICK_S

MAX31855_RANGE_C = {
    "K": (-200.0, 1350.0),
    "J": (-210.0, 1200.0),
    "N": (-200.0, 1300.0),
    "T": (-250.0, 400.0),
    "S": (-50.0, 1768.0),
    "R": (-50.0, 1768.0),
    "E": (-200.0, 1000.0),
}
"""Range by the thermocouple's type (data sheet, thermal characteristics)."""


class Converter(Averaged):
    """A converter, on any pins."""

    kind: str
    chip_select: PinName = Field(description="Pin at the converter's CS.")
    clock: PinName = Field(description="Pin at the converter's SCK.")
    on_adc: ClassVar[Literal[False]] = False
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[False]] = False
    rules: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 17)
    step_k: ClassVar[float]
    """Smallest difference that the converter resolves, K (data sheets)."""

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Step of the readings, K, which is the same at each temperature."""
        del temperature_c, mcu
        return self.step_k

    def fitting(self, period_s: float) -> str:
        """Return no text: no setting that the spec leaves open makes a conversion shorter."""
        del period_s
        return ""


class _ThreeWires(Converter):
    """A converter that can only be read."""

    data_out: PinName = Field(description="Pin at the converter's SO.")
    data_in: ClassVar[None] = None
    reading_bits: ClassVar[int] = 16
    selectable: ClassVar[tuple[str, ...]] = ()
    step_k: ClassVar[float] = 0.25


class Max6675(_ThreeWires, Started):
    """A thermocouple of type K behind a MAX6675."""

    kind: Literal["max6675"]
    least: ClassVar[Least] = Least(225, 5)
    clips_c: ClassVar[tuple[float, float] | None] = (0.0, 1023.75)

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature that it measures, °C (data sheet)."""
        return 0.0, 1023.75

    def error_k(self, temperature_c: float) -> float:
        """Largest error at a temperature, K: at 5 V, with 3 K of the cold junction (data sheet)."""
        return 3.0 + (9 if temperature_c <= 700.0 else 19) * self.step_k

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion, s (data sheet)."""
        return 0.22

    @property
    def read_s(self) -> float:
        """Time of the reading, s: one tick more, because a reading stops the conversion."""
        return TICK_S


class Max31855(_ThreeWires):
    """A thermocouple behind the MAX31855 that is made for its type."""

    kind: Literal["max31855"]
    thermocouple: Literal["K", "J", "N", "T", "S", "R", "E"] = Field(
        "K", description="Type of the thermocouple, the last letter of the converter's name."
    )
    least: ClassVar[Least] = Least(275, 5)
    clips_c: ClassVar[tuple[float, float] | None] = (-270.0, 1800.0)

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature that it measures, °C (data sheet)."""
        return MAX31855_RANGE_C[self.thermocouple]

    def error_k(self, temperature_c: float) -> float:
        """Largest error, K: 2 K up to 700 °C, 4 K above, and 2 K of the cold junction.

        The numbers are from the data sheet, thermal characteristics. They do not include how far
        the thermocouple's curve is from the straight line that the converter assumes.
        """
        return 4.0 if temperature_c <= 700.0 else 6.0

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion, s (data sheet)."""
        return 0.1

    @property
    def free_running_s(self) -> float:
        """Interval of its conversions, which it starts by itself, one after the other, s."""
        return self.conversion_s

    @property
    def read_s(self) -> float:
        """Time of one more conversion, s, because they are not synchronous with the loop."""
        return 0.1

    @property
    def first_s(self) -> float:
        """Time from the power-up to the first reading, s: 0.2 s (data sheet) and a conversion."""
        return 0.3
