"""A newsensor: its keys in a spec, and its properties."""

from typing import ClassVar, Literal

from pydantic import Field

from heatwright.spec.base import Least, PinName
from heatwright.spec.sensing.averaging import Averaged


class Newsensor(Averaged):
    """A newsensor on a pin."""

    kind: Literal["newsensor"]
    pin: PinName = Field(description="Pin of its line.")
    least: ClassVar[Least] = Least(200, 5)  # flash, RAM: 15 % below those of `heatwright build`
    on_adc: ClassVar[Literal[False]] = False
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[False]] = False
    rules: ClassVar[tuple[int, ...]] = (1, 4)  # codes of the rules that its readings can break
    reading_bits: ClassVar[int] = 16  # bits of the signed number that holds a reading
    clips_c: ClassVar[tuple[float, float] | None] = None  # lowest and highest reading it can show
    selectable: ClassVar[tuple[str, ...]] = ()

    @property
    def range_c(self) -> tuple[float, float]:
        """Lowest and highest temperature it measures (data sheet), °C."""
        raise NotImplementedError

    @property
    def step_k(self) -> float:
        """Largest temperature difference of one step of its readings, K."""
        raise NotImplementedError

    def step_at_k(self, temperature_c: float, mcu: str) -> float:
        """Temperature difference of one step of the readings at a temperature, K."""
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
        """Time between conversions that the sensor starts by itself, s; 0 if it starts none."""
        raise NotImplementedError

    @property
    def read_s(self) -> float:
        """Time to start a conversion and to read its result, s."""
        raise NotImplementedError

    @property
    def first_s(self) -> float:
        """Time from power-up to the first reading, s; 0 if it comes with the first period."""
        raise NotImplementedError

    def fitting(self, period_s: float) -> str:
        """Name the sensor's keys that would make it fit into a period; "" if there are none."""
        raise NotImplementedError
