"""The registers of a MAX31856, as its data sheet lists them ("Internal Registers")."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

from heatwright.sim.sensors.thermovoltage import Type

CR0, CR1, MASK, CJHF, CJLF, LTHFTH, LTHFTL, LTLFTH, LTLFTL, CJTO = range(10)
CJTH, CJTL, LTCBH, LTCBM, LTCBL, SR = range(10, 16)
POWER_ON = bytes([0, 3, 0xFF, 0x7F, 0xC0, 0x7F, 0xFF, 0x80, 0, 0, 0, 0, 0, 0, 0, 0])
"""What they hold after the supply has come."""

CJ_RANGE, TC_RANGE, CJ_HIGH, CJ_LOW, TC_HIGH, TC_LOW, OVUV, OPEN = (
    1 << bit for bit in range(7, -1, -1)
)
"""Bits of SR."""
AUTOMATIC, ONCE, TESTS_OPEN, NO_JUNCTION, KEEPS, CLEARS, FIFTY = 0x80, 0x40, 0x30, 8, 4, 2, 1
"""Bits of CR0."""
TYPES: tuple[Type, ...] = ("B", "E", "J", "K", "N", "R", "S", "T")
"""In the order of their codes in CR1; the codes from 8 on give a voltage, and are not here."""

SETTINGS_BITS = tuple(range(8 * (SR - CJTO), 8 * (SR + 1)))
"""Bits of all registers in a row, 0 the last: those that the program has written."""
UNSAID_LTCBL, UNSAID_CJTL = 0x1F, 0x03
"""Bits below the temperatures'. The data sheet does not say what they are: here ones, which a
program that goes by them would notice."""

FIRST_S = {50.0: (0.185, 2 / 50), 60.0: (0.155, 2 / 60)}
NEXT_S = {50.0: (0.11, 1 / 50), 60.0: (0.09, 1 / 60)}
"""Longest conversion, and what each sample more adds, by the mains' frequency: the first one after
a stop, and those that follow it."""
TEST_S = {0x00: 0.0, 0x10: 0.015, 0x20: 0.037, 0x30: 0.125}
"""What the test for an open thermocouple adds to a conversion, at most, by its kind."""


@dataclass(frozen=True)
class Settings:
    """What the registers ask of the chip."""

    registers: bytes

    @property
    def automatic(self) -> bool:
        """Whether it converts again and again."""
        return bool(self.registers[CR0] & AUTOMATIC)

    @property
    def once(self) -> bool:
        """Whether one conversion is asked for."""
        return not self.automatic and bool(self.registers[CR0] & ONCE)

    @property
    def lasting(self) -> int:
        """What stays of CR0: two of its bits clear themselves."""
        return self.registers[CR0] & ~(ONCE | CLEARS)

    @property
    def tests_open(self) -> bool:
        """Whether it looks for an open thermocouple."""
        return bool(self.registers[CR0] & TESTS_OPEN)

    @property
    def measures_junction(self) -> bool:
        """Whether the cold junction's temperature is its own, not one it was told."""
        return not self.registers[CR0] & NO_JUNCTION

    @property
    def keeps_faults(self) -> bool:
        """Whether bits of SR stay until they are cleared."""
        return bool(self.registers[CR0] & KEEPS)

    @property
    def clears_faults(self) -> bool:
        """Whether that is asked for now."""
        return bool(self.registers[CR0] & CLEARS)

    @property
    def mains_hz(self) -> float:
        """What it filters out."""
        return 50.0 if self.registers[CR0] & FIFTY else 60.0

    @property
    def samples(self) -> int:
        """How many samples it averages."""
        return min(1 << (self.registers[CR1] >> 4 & 7), 16)

    @property
    def type(self) -> int:
        """Code of the thermocouple's type."""
        return self.registers[CR1] & 7

    @property
    def offset_c(self) -> float:
        """What it adds to its own temperature, °C."""
        return _signed(self.registers[CJTO : CJTO + 1]) / 16

    def may_write(self, place: int) -> bool:
        """Return whether a register takes what is written to it."""
        return place <= CJTO or (place in {CJTH, CJTL} and not self.measures_junction)

    @cached_property
    def first_s(self) -> float:
        """How long the first conversion after a stop takes at most, s."""
        return self._conversion_s(FIRST_S)

    @cached_property
    def next_s(self) -> float:
        """How long those take that follow it, s."""
        return self._conversion_s(NEXT_S)

    @cached_property
    def test_s(self) -> float:
        """What the test for an open thermocouple adds, s."""
        return TEST_S[self.registers[CR0] & TESTS_OPEN]

    def _conversion_s(self, times: Mapping[float, tuple[float, float]]) -> float:
        alone_s, each_s = times[self.mains_hz]
        return alone_s + (self.samples - 1) * each_s


def junction_c(registers: bytes | bytearray) -> float:
    """Return the cold junction's temperature as it stands in its registers, °C."""
    return (_signed(registers[CJTH : CJTL + 1]) >> 2) / 64


def threshold_bits(registers: bytes) -> int:
    """Return the bits of SR that say on which side of its thresholds a temperature is."""
    cold_c, code = junction_c(registers), _signed(registers[LTCBH : LTCBM + 1])
    cold_high_c, cold_low_c, high, low = _thresholds(registers[CJHF:CJTO])
    bits = CJ_HIGH * (cold_c > cold_high_c) | CJ_LOW * (cold_c < cold_low_c)
    return bits | TC_HIGH * (code > high) | TC_LOW * (code < low)


@lru_cache(maxsize=64)
def _thresholds(registers: bytes) -> tuple[int, int, int, int]:
    """Return the highest and lowest cold junction, °C, and the highest and lowest code."""
    edges = (0, CJLF - CJHF, LTHFTH - CJHF, LTLFTH - CJHF, len(registers))
    cold_high_c, cold_low_c, high, low = (_signed(registers[a:b]) for a, b in pairwise(edges))
    return cold_high_c, cold_low_c, high, low


def _signed(register: bytes | bytearray) -> int:
    return int.from_bytes(register, "big", signed=True)
