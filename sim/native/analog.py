"""Analog inputs of a simulated processor."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.hw import Hw

CODES = 1024


def millivolts(code: float, reference_mv: float = 5000.0) -> float:
    """Return the voltage in the middle of an ADC code, mV."""
    return (code + 0.5) * reference_mv / CODES


class Curve(NamedTuple):
    """Voltage at a pin over a sensor's value in its unit, linear between two points.

    first -- the sensor's value at the first point; per_unit -- points per unit.
    """

    first: float
    per_unit: float
    millivolts: NDArray[np.float64]

    @property
    def last(self) -> float:
        """The sensor's value at the last point."""
        return self.first + (len(self.millivolts) - 1) / self.per_unit


class Adc:
    """The ADC: code = floor(1024 V / Vref) within 0..1023, taken when the conversion starts."""

    def __init__(self, hw: Hw) -> None:
        self._lib, self._ffi, self._hw = hw.lib, hw.ffi, hw.pointer
        self._curves: dict[int, object] = {}

    def bend(self, channel: int, curve: Curve | None) -> None:
        """Set the curve from a sensor's value to an input's voltage; None: no curve, only `set`."""
        self._curves.pop(channel, None)
        if curve is None:
            self._lib.hw_adc_curve(self._hw, channel, self._ffi.NULL, 0, 0.0, 0.0)
            return
        points = self._ffi.from_buffer("double[]", curve.millivolts)
        self._lib.hw_adc_curve(self._hw, channel, points, len(points), curve.first, curve.per_unit)
        self._curves[channel] = points

    def sense(self, channel: int, felt: float) -> bool:
        """Set an input's voltage by its curve, for a sensor's value; return False beyond the curve.

        The sensor's value is stored in either case.
        """
        return bool(self._lib.hw_adc_sense(self._hw, channel, felt))

    def felt(self, channel: int) -> float:
        """Return the sensor's value that was last set at an input, in its unit."""
        return float(self._lib.hw_adc_felt(self._hw, channel))

    def set(self, channel: int, voltage_mv: float) -> None:
        """Set the voltage of an input, mV."""
        self._lib.hw_adc_set(self._hw, channel, voltage_mv)

    def reference(self, *, aref_mv: float, avcc_mv: float) -> None:
        """Set the voltages of the AREF and AVCC pins, mV."""
        self._lib.hw_adc_reference(self._hw, aref_mv, avcc_mv)

    def known(self, code: int, voltage_mv: float) -> None:
        """Set the voltage, mV, of the input that this code of ADMUX selects: the band gap."""
        self._lib.hw_adc_known(self._hw, code, voltage_mv)

    def fail(self, *, hung: bool = False, stuck: bool = False) -> None:
        """Let the ADC fail from the next conversion on, or repair the ADC.

        hung -- no conversion ends; stuck -- each ends with the last code of its channel.
        """
        self._lib.hw_adc_fail(self._hw, hung, stuck)

    @property
    def conversions(self) -> int:
        """Number of conversions started."""
        return int(self._lib.hw_adc_conversions(self._hw))
