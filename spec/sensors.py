"""Sensors: one model for each kind."""

from typing import Annotated, Literal

from pydantic import Field

from heatwright.spec.base import Model, PinName
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import BITS


class Ds18b20(Model):
    """Digital thermometer on a 1-Wire line of its own, with its own supply wire."""

    kind: Literal["ds18b20"]
    pin: PinName = Field(description="Data line; it needs a pull-up resistor of 4.7 kΩ.")
    resolution_bits: Annotated[int, Quantity(BITS, choices=(9, 10, 11, 12))] = Field(
        12,
        alias="resolution",
        description="9 to 12 bit: steps of 0.5, 0.25, 0.125 or 0.0625 K; each doubles the time.",
    )

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature it measures (data sheet)."""
        return -55.0, 125.0

    def error_k(self, temperature_c: float) -> float:
        """Largest error at a temperature (data sheet, thermometer error)."""
        if -10.0 <= temperature_c <= 85.0:
            return 0.5
        return 1.0 if -30.0 <= temperature_c <= 100.0 else 2.0

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion, from the data sheet: 93.75 ms at 9 bit to 750 ms."""
        return float(0.09375 * 2 ** (self.resolution_bits - 9))

    @property
    def step_k(self) -> float:
        """Smallest difference the sensor resolves."""
        return float(0.5 / 2 ** (self.resolution_bits - 9))


Sensor = Annotated[Ds18b20, Field(discriminator="kind")]
