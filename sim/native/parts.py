"""Differences between the simulated parts that simavr does not know (data sheets)."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """First RAM address; sleep register, its enable and mode bits; time to write an EEPROM byte.

    adc_mux5 -- the bit in ADCSRB that selects channels 8 to 15, 0: there are none; adc_known -- the
    code in ADMUX that selects the band gap's voltage; old -- whether timers, watchdog and ports are
    of the older generation (old.c).
    """

    ram_start: int
    sleep_register: int
    sleep_enable: int
    sleep_mode: int
    eeprom_write_s: float
    adc_mux5: int = 0
    old: bool = False
    adc_known: int = 0x1E

    @property
    def known_mv(self) -> float:
        """The band gap's typical voltage, mV (data sheets)."""
        return 1220.0 if self.old else 1100.0

    @property
    def shortest_watchdog_s(self) -> float:
        """Shortest timeout, s: 2048 cycles at typically 128 kHz; on old parts 16384 at 1 MHz."""
        return 16384 / 1e6 if self.old else 2048 / 128e3


PARTS: Mapping[str, Part] = {
    "atmega328p": Part(0x100, 0x53, 0x01, 0x0E, 0.0033, adc_known=0x0E),
    "atmega644p": Part(0x100, 0x53, 0x01, 0x0E, 0.0033),
    "atmega1284p": Part(0x100, 0x53, 0x01, 0x0E, 0.0033),
    "atmega32u4": Part(0x100, 0x53, 0x01, 0x0E, 0.0033, adc_mux5=1 << 5),
    "atmega2560": Part(0x200, 0x53, 0x01, 0x0E, 0.0033, adc_mux5=1 << 3),
    "atmega32": Part(0x60, 0x55, 0x80, 0x70, 0.0085, old=True),
    "atmega16": Part(0x60, 0x55, 0x40, 0xB0, 0.0085, old=True),
}
