"""Between temperatures and the codes of a sensor, for courses that go to a temperature."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module

import numpy as np

from heatwright.spec import Controller
from heatwright.spec.registry import module_of

ADC_CODES = 1024


@dataclass(frozen=True)
class Steps:
    """Codes that are whole numbers of a part of a kelvin."""

    per_k: int
    lowest: int
    highest: int
    """Codes that may come; those of `noise` are where the sensor mostly is."""
    noise: tuple[int, int]
    first = 0

    def celsius(self, code: int) -> float:
        return code / self.per_k

    def code(self, celsius: float) -> int:
        return round(celsius * self.per_k)

    def moved(self, code: int, by_k: float) -> int:
        """Return the code farthest from another that is no more than `by_k` from it."""
        return code + int(by_k * self.per_k)


_QUARTERS = Steps(4, 0, 4095, (0, 4095))
_STEPS = {
    "ds18b20": Steps(16, -(2**15), 2**15 - 1, (-55 * 16, 125 * 16)),
    "max31856": Steps(128, -(2**18), 2**18 - 1, (-200 * 128, 1372 * 128)),
    "max6675": _QUARTERS,
    "max31855": _QUARTERS,  # from 0 °C on
}


class Table:
    """A sum of codes of the ADC, made a temperature by the reference's table."""

    def __init__(self, controller: Controller, name: str) -> None:
        sensor = controller.sensors[name]
        convert = import_module(module_of("sensor", "reference", sensor.kind)).converter(
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
def scale_of(controller: Controller) -> Steps | Table:
    ((_, loop),) = controller.loops.items()
    kind = controller.sensors[loop.sensor].kind
    return _STEPS[kind] if kind in _STEPS else Table(controller, loop.sensor)
