"""Analog inputs of a simulated processor."""

from __future__ import annotations

from heatwright.sim.native.hw import Hw

CODES = 1024


def millivolts(code: float, reference_mv: float = 5000.0) -> float:
    """Return the voltage in the middle of an ADC code, mV."""
    return (code + 0.5) * reference_mv / CODES


class Adc:
    """The ADC: code = floor(1024 V / Vref) within 0..1023, taken when the conversion starts."""

    def __init__(self, hw: Hw) -> None:
        self._lib, self._hw = hw.lib, hw.pointer

    def set(self, channel: int, voltage_mv: float) -> None:
        """Put a voltage on an input, mV."""
        self._lib.hw_adc_set(self._hw, channel, voltage_mv)

    def reference(self, *, aref_mv: float, avcc_mv: float) -> None:
        """Set the voltages of the AREF and AVCC pins, mV."""
        self._lib.hw_adc_reference(self._hw, aref_mv, avcc_mv)

    def fail(self, *, hung: bool = False, stuck: bool = False) -> None:
        """Fail from the next conversion on, or no longer.

        hung -- none ends; stuck -- each ends with the code its channel had last.
        """
        self._lib.hw_adc_fail(self._hw, hung, stuck)

    @property
    def conversions(self) -> int:
        """Conversions started."""
        return int(self._lib.hw_adc_conversions(self._hw))
