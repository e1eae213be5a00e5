"""A newsensor: its keys, and what is known of it."""

from typing import ClassVar, Literal

from pydantic import Field

from heatwright.spec.base import Least, PinName
from heatwright.spec.sensing.averaging import Averaged


class Newsensor(Averaged):
    """A newsensor on a pin."""

    kind: Literal["newsensor"]
    pin: PinName = Field(description="Pin at its line.")
    least: ClassVar[Least] = Least(200, 5)  # 15 % below what `heatwright build` tells of it
    on_adc: ClassVar[Literal[False]] = False
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[False]] = False
    reading_bits: ClassVar[int] = 16  # of the signed number that holds a reading
    clips_c: ClassVar[tuple[float, float] | None] = None  # lowest and highest reading it can show
    selectable: ClassVar[tuple[str, ...]] = ()

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature it measures (data sheet), °C."""
        raise NotImplementedError

    @property
    def step_k(self) -> float:
        """Largest difference that a step of its readings stands for, K."""
        raise NotImplementedError

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Step of the readings about a temperature, K."""
        raise NotImplementedError

    def error_k(self, temperature_c: float) -> float:
        """Largest error at a temperature (data sheet), K."""
        raise NotImplementedError

    @property
    def conversion_s(self) -> float:
        """Longest time of one conversion (data sheet), s."""
        raise NotImplementedError

    @property
    def free_running_s(self) -> float:
        """Time between conversions that nobody asked for, s; 0 if each is asked for."""
        raise NotImplementedError

    @property
    def read_s(self) -> float:
        """From the end of a conversion to the reading, with what comes before the conversion, s."""
        raise NotImplementedError

    @property
    def first_s(self) -> float:
        """From the power-up to the first reading, s; 0 if it begins with the first period."""
        raise NotImplementedError

    def fitting(self, period_s: float) -> str:
        """Name keys of its own that would have it fit into a period; nothing if there are none."""
        raise NotImplementedError
