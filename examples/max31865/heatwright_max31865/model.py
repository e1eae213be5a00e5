"""A platinum element behind a MAX31865, on any four pins: its keys, and what is known of it."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from heatwright.spec.base import Least, PinName, WholeNumber
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.sensing.averaging import Averaged
from heatwright.spec.sensing.conversion import TICK_S
from heatwright.spec.units import FREQUENCY, RESISTANCE

OHM_AT_0 = {"pt100": 100.0, "pt1000": 1000.0}
LEAST_REFERENCE, MOST_REFERENCE = 4.0, 5.0
"""In times of the element at 0 °C: at 850 °C it has 3.905 times its resistance."""
CODES = 2**15
READ_TICKS, SET_UP_TICKS = 4, 3
"""What the firmware takes at most to read all registers and judge, and to set the chip up."""
POLYNOMIAL_K = 0.02
"""What the firmware's polynomial, in single precision, leaves of IEC 60751 at most."""


class Max31865(Averaged):
    """A platinum element behind a MAX31865, on any four pins."""

    kind: Literal["max31865"]
    chip_select: PinName = Field(description="Pin at the converter's CS.")
    clock: PinName = Field(description="Pin at its SCLK.")
    data_in: PinName = Field(description="Pin at its SDI: what it is told.")
    data_out: PinName = Field(description="Pin at its SDO: what it answers.")
    element: Literal["pt100", "pt1000"] = Field(description="100 Ω or 1000 Ω at 0 °C.")
    reference_ohm: Annotated[float, Quantity(RESISTANCE, least=400.0, most=5000.0)] = Field(
        alias="reference", description="The reference resistor: 4 to 5 times the element's."
    )
    wires: Annotated[int, WholeNumber("a number of wires", 2, 4, 3)] = Field(
        2, description="Wires to the element: 2, 3 or 4."
    )
    mains_filter_hz: Annotated[float, Quantity(FREQUENCY, choices=(50.0, 60.0))] = Field(
        50.0, alias="mains_filter", description="Mains frequency that the chip filters out."
    )
    least: ClassVar[Least] = Least(600, 20)
    on_adc: ClassVar[Literal[False]] = False
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[False]] = False
    rules: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5, 17, 18)
    reading_bits: ClassVar[int] = 16
    clips_c: ClassVar[tuple[float, float] | None] = None
    selectable: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _reference_fits(self) -> "Max31865":
        if not LEAST_REFERENCE <= self.reference_ohm / self.ohm_at_0 <= MOST_REFERENCE:
            raise refuse(
                f"a reference of {self.reference_ohm:g} Ω does not fit a {self.element}",
                "Use a resistor of 4 to 5 times the element's resistance at 0 °C",
            )
        return self

    @property
    def ohm_at_0(self) -> float:
        """The element's resistance at 0 °C, Ω."""
        return OHM_AT_0[self.element]

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature it measures (IEC 60751)."""
        return -200.0, 850.0

    @property
    def step_k(self) -> float:
        """Largest difference that a step of the code stands for: at the upper end."""
        return self._step_at_k(self.range_c[1])

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Step of the readings about a temperature: the chip's, whatever reads it."""
        del mcu
        return self._step_at_k(temperature_c)

    def _step_at_k(self, temperature_c: float) -> float:
        """Return what a step of the code is in K, from the slope of IEC 60751 above 0 °C."""
        slope_per_k = 3.9083e-3 - 2 * 5.775e-7 * temperature_c
        return self.reference_ohm / CODES / (self.ohm_at_0 * slope_per_k)

    def error_k(self, temperature_c: float) -> float:
        """Largest error at a temperature: an element of class B, and 0.5 K of the chip."""
        return 0.3 + 0.005 * abs(temperature_c) + 0.5 + POLYNOMIAL_K

    def fitting(self, period_s: float) -> str:
        """Offer nothing: no key makes a conversion shorter."""
        del period_s
        return ""

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion, all but the first (data sheet)."""
        return 0.021 if self.mains_filter_hz == 50.0 else 0.0176

    @property
    def free_running_s(self) -> float:
        """Time between two of its conversions, which follow each other without end."""
        return self.conversion_s

    @property
    def read_s(self) -> float:
        """Time for another conversion, for it converts all the time; and to read it."""
        return self.conversion_s + READ_TICKS * TICK_S

    @property
    def first_conversion_s(self) -> float:
        """Longest time of the first conversion after it was set up (data sheet)."""
        return 0.066 if self.mains_filter_hz == 50.0 else 0.055

    @property
    def first_s(self) -> float:
        """From the power-up to the first reading: it is set up, converts and is read."""
        return self.first_conversion_s + (SET_UP_TICKS + READ_TICKS) * TICK_S
