"""Analog inputs of a simulated processor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.native.hw import Hw

CODES = 1024


def millivolts(code: float, reference_mv: float = 5000.0) -> float:
    """Return the voltage in the middle of an ADC code, mV."""
    return (code + 0.5) * reference_mv / CODES


class Curve(NamedTuple):
    """Voltages at a pin by what a sensor there feels, in its unit, straight between two points.

    first -- what the first point is for; per_unit -- points for each unit.
    """

    first: float
    per_unit: float
    millivolts: NDArray[np.float64]


class Adc:
    """The ADC: code = floor(1024 V / Vref) within 0..1023, taken when the conversion starts."""

    def __init__(self, hw: Hw) -> None:
        self._lib, self._ffi, self._hw = hw.lib, hw.ffi, hw.pointer
        self._curves: dict[int, object] = {}

    def bend(self, channel: int, curve: Curve | None) -> None:
        """Let what is felt make the voltage of an input; None: only `set` does."""
        self._curves.pop(channel, None)
        if curve is None:
            self._lib.hw_adc_curve(self._hw, channel, self._ffi.NULL, 0, 0.0, 0.0)
            return
        points = self._ffi.from_buffer("double[]", curve.millivolts)
        self._lib.hw_adc_curve(self._hw, channel, points, len(points), curve.first, curve.per_unit)
        self._curves[channel] = points

    def sense(self, channel: int, felt: float) -> bool:
        """Put the voltage on an input that its curve has for what is felt; False beyond its ends.

        What is felt is remembered either way.
        """
        return bool(self._lib.hw_adc_sense(self._hw, channel, felt))

    def felt(self, channel: int) -> float:
        """Return what was felt last at an input."""
        return float(self._lib.hw_adc_felt(self._hw, channel))

    def set(self, channel: int, voltage_mv: float) -> None:
        """Put a voltage on an input, mV."""
        self._lib.hw_adc_set(self._hw, channel, voltage_mv)

    def reference(self, *, aref_mv: float, avcc_mv: float) -> None:
        """Set the voltages of the AREF and AVCC pins, mV."""
        self._lib.hw_adc_reference(self._hw, aref_mv, avcc_mv)

    def known(self, code: int, voltage_mv: float) -> None:
        """Set what the input ADMUX calls by this code measures, mV: the band gap's voltage."""
        self._lib.hw_adc_known(self._hw, code, voltage_mv)

    def fail(self, *, hung: bool = False, stuck: bool = False) -> None:
        """Fail from the next conversion on, or no longer.

        hung -- none ends; stuck -- each ends with the code its channel had last.
        """
        self._lib.hw_adc_fail(self._hw, hung, stuck)

    @property
    def conversions(self) -> int:
        """Conversions started."""
        return int(self._lib.hw_adc_conversions(self._hw))
