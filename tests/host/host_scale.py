"""Between temperatures and the codes of a sensor, for courses that go to a temperature."""

from functools import cache
from importlib import import_module
from typing import Protocol

import numpy as np

from heatwright.spec import Controller, Max6675, Max31855, Max31856
from heatwright.spec.sensors import Ds18b20

ADC_CODES = 1024


class Scale(Protocol):
    lowest: int
    highest: int
    """Codes that may come; those of `noise` are where the sensor mostly is."""
    noise: tuple[int, int]
    first: int

    def celsius(self, code: int) -> float: ...

    def code(self, celsius: float) -> int:
        """Return the nearest code."""

    def moved(self, code: int, by_k: float) -> int:
        """Return the code farthest from another that is no more than `by_k` from it."""


class _Steps:
    """Codes that are whole numbers of a part of a kelvin."""

    lowest, highest = -(2**15), 2**15 - 1
    noise = (0, 0)
    first = 0
    per_k = 1

    def celsius(self, code: int) -> float:
        return code / self.per_k

    def code(self, celsius: float) -> int:
        return round(celsius * self.per_k)

    def moved(self, code: int, by_k: float) -> int:
        return code + int(by_k * self.per_k)


class Sixteenths(_Steps):
    """Of a DS18B20."""

    noise = (-55 * 16, 125 * 16)
    per_k = 16


class Parts128(_Steps):
    """Of a MAX31856, which has 19 bits."""

    lowest, highest = -(2**18), 2**18 - 1
    noise = (-200 * 128, 1372 * 128)
    per_k = 128


class Quarters(_Steps):
    """Of a MAX6675, and of a MAX31855 from 0 °C on."""

    lowest, highest = 0, 4095
    noise = (0, 4095)
    per_k = 4


class _Table:
    """A sum of codes of the ADC, made a temperature by the reference's table."""

    def __init__(self, controller: Controller, name: str) -> None:
        sensor = controller.sensors[name]
        convert = import_module(f"heatwright.sim.reference.{sensor.kind}").converter(
            sensor, controller.board
        )
        self.lowest, self.highest = 0, (ADC_CODES - 1) * sensor.oversample
        self._celsius = np.array([float(convert(raw)) for raw in range(self.highest + 1)])
        self._falls = bool(self._celsius[0] > self._celsius[-1])
        self._rising = self._celsius[::-1] if self._falls else self._celsius
        low, high = sorted(self.code(each) for each in sensor.range_c)
        self.noise = (low, high)
        self.first = self.code(20.0)

    def celsius(self, code: int) -> float:
        return float(self._celsius[min(max(code, 0), self.highest)])

    def code(self, celsius: float) -> int:
        place = int(np.searchsorted(self._rising, celsius))
        near = [max(0, place - 1), min(place, self.highest)]
        best = min(near, key=lambda each: abs(self._rising[each] - celsius))
        return self.highest - best if self._falls else best

    def moved(self, code: int, by_k: float) -> int:
        wanted_c = self.celsius(code) + by_k
        if by_k > 0:
            best = int(np.searchsorted(self._rising, wanted_c, "right")) - 1
        else:
            best = int(np.searchsorted(self._rising, wanted_c, "left"))
        best = min(max(best, 0), self.highest)
        return self.highest - best if self._falls else best


@cache
def scale_of(controller: Controller) -> Scale:
    """Return the scale of the sensor of a controller's only loop."""
    ((_, loop),) = controller.loops.items()
    sensor = controller.sensors[loop.sensor]
    if isinstance(sensor, Ds18b20):
        return Sixteenths()
    if isinstance(sensor, Max31856):
        return Parts128()
    if isinstance(sensor, Max6675 | Max31855):
        return Quarters()
    return _Table(controller, loop.sensor)
